#include "host/canonical.h"

#include <algorithm>
#include <cstddef>

namespace topotag {

CanonicalComponents::CanonicalComponents(const Components& components) {
  number.resize(components.label_end());
  for (const auto& [begin, end] : components.ranges) {
    for (uint32_t label = begin; label < end; ++label) {
      const uint32_t root = components.root[label];
      if (root != label) {
        number[label] = number[root];
        continue;
      }
      number[label] = static_cast<uint32_t>(parent.size());
      parent.push_back(number[components.parent[label]]);
      white.push_back(components.white[label]);
    }
  }
}

std::vector<uint32_t> CanonicalLabels(const Components& components) {
  const CanonicalComponents canonical(components);
  const auto width = static_cast<size_t>(components.width);
  std::vector<uint32_t> labels;
  labels.reserve(width * static_cast<size_t>(components.height));
  for (size_t y = 0; y < static_cast<size_t>(components.height); ++y) {
    const uint32_t begin = components.row_begin[y];
    for (uint32_t i = begin; i < begin + components.row_runs[y]; ++i) {
      const auto end = std::min(static_cast<size_t>(components.bound[i + 1]), width);
      labels.resize(y * width + end, canonical.number[components.label[i]]);
    }
  }
  return labels;
}

}  // namespace topotag
