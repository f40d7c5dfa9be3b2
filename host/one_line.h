#ifndef TOPOTAG_HOST_ONE_LINE_H_
#define TOPOTAG_HOST_ONE_LINE_H_

#include <cstddef>
#include <string>

namespace topotag {

/// The text with blanks for control characters, those of UTF-8 beyond ASCII (C2 80 .. C2 9F) as
/// well: a message is one line, and no terminal takes orders from it, whatever bytes of a file or
/// an argument it quotes.
inline std::string OneLine(std::string text) {
  const auto byte = [&text](size_t i) { return static_cast<unsigned char>(text[i]); };
  for (size_t i = 0; i < text.size(); ++i) {
    if (byte(i) == 0xc2 && i + 1 < text.size() && byte(i + 1) >= 0x80 && byte(i + 1) < 0xa0) {
      text[i] = text[i + 1] = ' ';
    }
    if (byte(i) < 0x20 || byte(i) == 0x7f) text[i] = ' ';
  }
  return text;
}

}  // namespace topotag

#endif  // TOPOTAG_HOST_ONE_LINE_H_
