#include "topotag/family.h"

#include <algorithm>

#include "host/check.h"

namespace topotag {

Family::Family(int n) : n_(n) {
  if (n < kMinN || n > kMaxN) {
    FailArgument("family " + std::to_string(n) + "x" + std::to_string(n) +
                 " is not one of 3x3 .. 8x8");
  }
}

Family Family::Parse(const std::string& name) {
  if (name.size() == 3 && name[1] == 'x' && name[0] == name[2] && name[0] >= '0' + kMinN &&
      name[0] <= '0' + kMaxN) {
    return Family(name[0] - '0');
  }
  FailArgument("unknown family '" + name + "': expected one of 3x3, 4x4, 5x5, 6x6, 7x7, 8x8");
}

std::vector<Family> Family::ParseList(const std::string& names) {
  std::vector<Family> families;
  for (size_t begin = 0; begin <= names.size();) {
    const size_t end = std::min(names.find(',', begin), names.size());
    const Family family = Parse(names.substr(begin, end - begin));
    if (std::find(families.begin(), families.end(), family) != families.end()) {
      FailArgument("family " + family.name() + " is named twice");
    }
    families.push_back(family);
    begin = end + 1;
  }
  return families;
}

std::string Family::name() const { return std::to_string(n_) + "x" + std::to_string(n_); }

}  // namespace topotag
