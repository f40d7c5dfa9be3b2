#ifndef TOPOTAG_HOST_ONE_LINE_H_
#define TOPOTAG_HOST_ONE_LINE_H_

#include <string>

namespace topotag {

/// The text with blanks for control characters: a message is one line, and no terminal takes orders
/// from it, whatever bytes of a file or an argument it quotes.
inline std::string OneLine(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return text;
}

}  // namespace topotag

#endif  // TOPOTAG_HOST_ONE_LINE_H_
