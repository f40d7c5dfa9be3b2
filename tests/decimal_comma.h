#ifndef TOPOTAG_TESTS_DECIMAL_COMMA_H_
#define TOPOTAG_TESTS_DECIMAL_COMMA_H_

#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/temporary_folder.h"

namespace topotag::test {

/// While it lives, and where Works(), printf writes 0,5: with a locale of the system or, where none
/// is installed, one that localedef makes for this.
class DecimalComma {
 public:
  DecimalComma() {
    for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "es_ES.UTF-8"}) {
      if (std::setlocale(LC_ALL, name) != nullptr && Works()) return;
    }
    const std::string made = (folder_.path() / "de_DE.UTF-8").string();
    const std::string command = "localedef -i de_DE -f UTF-8 '" + made + "' 2> /dev/null";
    if (std::system(command.c_str()) != 0) return;
    setenv("LOCPATH", folder_.path().c_str(), 1);
    std::setlocale(LC_ALL, "de_DE.UTF-8");
    unsetenv("LOCPATH");
  }
  DecimalComma(const DecimalComma&) = delete;
  DecimalComma& operator=(const DecimalComma&) = delete;
  ~DecimalComma() { std::setlocale(LC_ALL, "C"); }

  bool Works() const {
    char text[8];
    std::snprintf(text, sizeof text, "%g", 0.5);
    return std::string(text) == "0,5";
  }

 private:
  const TemporaryFolder folder_;
};

}  // namespace topotag::test

#endif  // TOPOTAG_TESTS_DECIMAL_COMMA_H_
