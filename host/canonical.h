#ifndef TOPOTAG_HOST_CANONICAL_H_
#define TOPOTAG_HOST_CANONICAL_H_

#include <cstdint>
#include <vector>

#include "host/pipeline.h"

namespace topotag {

/// Components in the form that is the same on every backend: numbered from 0, the outside, in
/// raster order of their first pixels. For comparisons and pictures.
struct CanonicalComponents {
  explicit CanonicalComponents(const Components& components);

  std::vector<uint32_t> number;  ///< of each label, that of its component
  std::vector<uint32_t> parent;  ///< number of the component around each one; parent[0] = 0
  std::vector<uint8_t> white;    ///< colour of each component
};

/// Component number of each pixel, row-major, width * height.
std::vector<uint32_t> CanonicalLabels(const Components& components);

}  // namespace topotag

#endif  // TOPOTAG_HOST_CANONICAL_H_
