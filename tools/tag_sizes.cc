#include "tools/tag_sizes.h"

#include <algorithm>

#include "tools/command.h"

namespace topotag::tools {
namespace {

constexpr char kOption[] = "--tag-size";

[[noreturn]] void FailTwice(const std::string& what) {
  throw UsageError(std::string(kOption) + ": the size of " + what + " is given twice");
}

/// "METRES", "FAMILY=METRES" or "FAMILY:LIST=METRES".
void AddTagSize(const std::string& item, Options* options) {
  const size_t equals = item.find('=');
  if (equals == std::string::npos) {
    const double size = ParsePositive(kOption, item);
    if (options->tag_size != 0) FailTwice("all markers");
    options->tag_size = size;
    return;
  }
  const double size = ParsePositive(kOption, item.substr(equals + 1));
  const std::string key = item.substr(0, equals);
  const size_t colon = key.find(':');
  const Family family = ForOption(kOption, [&] { return Family::Parse(key.substr(0, colon)); });
  if (std::find(options->families.begin(), options->families.end(), family) ==
      options->families.end()) {
    throw UsageError(std::string(kOption) + ": family " + family.name() +
                     " is not looked for; see --family");
  }
  if (colon == std::string::npos) {
    if (!options->family_tag_size.emplace(family.n(), size).second) FailTwice(family.name());
    return;
  }
  for (const uint64_t id : ParseIds(kOption, key.substr(colon + 1), family)) {
    if (!options->id_tag_size.emplace(std::pair(family.n(), id), size).second) {
      FailTwice(family.name() + " ID " + std::to_string(id));
    }
  }
}

}  // namespace

void AddTagSizes(const std::string& text, Options* options) {
  std::string item;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    item += text.substr(begin, end - begin);
    begin = end + 1;
    // A list of IDs has commas of its own.
    const bool is_open = item.find(':') != std::string::npos && item.find('=') == std::string::npos;
    if (is_open && begin > text.size()) {
      throw UsageError(std::string(kOption) + ": '" + item + "' is not FAMILY:LIST=METRES");
    }
    if (is_open) {
      item += ',';
      continue;
    }
    AddTagSize(item, options);
    item.clear();
  }
}

}  // namespace topotag::tools
