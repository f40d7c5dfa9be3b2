#include "host/ids.h"

#include <algorithm>
#include <string>
#include <utility>

#include "host/check.h"
#include "topotag/marker.h"

namespace topotag {

void ValidateIds(const IdLists& ids) {
  for (const auto& [n, list] : ids) {
    const std::string name = Text(n, n);
    if (n < Family::kMinN || n > Family::kMaxN) FailArgument("IDs of an unknown family " + name);
    if (list.empty()) FailArgument("no ID of family " + name + " is in use");
    const uint64_t largest = *std::max_element(list.begin(), list.end());
    if (largest >= Family(n).size()) {
      FailArgument("ID " + std::to_string(largest) + " of family " + name +
                   " is not in the range 0.." + std::to_string(Family(n).size() - 1));
    }
  }
}

IdsInUse::IdsInUse(IdLists ids) : ids_(std::move(ids)) {
  for (auto& [n, list] : ids_) std::sort(list.begin(), list.end());
}

bool IdsInUse::Admit(Decoded* decoded) const {
  const auto named = ids_.find(decoded->family.n());
  if (named == ids_.end()) return true;
  const std::vector<uint64_t>& list = named->second;
  const uint64_t id = decoded->id;
  if (decoded->hidden == 0) return std::binary_search(list.begin(), list.end(), id);
  const uint64_t known = ~IdFromVertexBits(decoded->family, decoded->hidden);
  const auto fits = [&](uint64_t other) { return (other & known) == id; };
  const auto first = std::find_if(list.begin(), list.end(), fits);
  if (first == list.end()) return false;
  const bool is_only = std::none_of(first, list.end(),
                                    [&](uint64_t other) { return other != *first && fits(other); });
  if (is_only) {
    decoded->id = *first;
    decoded->hidden = 0;
  }
  return true;
}

}  // namespace topotag
