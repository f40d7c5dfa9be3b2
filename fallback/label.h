#ifndef TOPOTAG_FALLBACK_LABEL_H_
#define TOPOTAG_FALLBACK_LABEL_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/pipeline.h"

namespace topotag::scalar {

/// Memory of Label, kept between frames.
struct LabelWorkspace {
  Buffer<uint64_t> readable;     ///< one band of rows without its noise
  std::vector<uint32_t> root;    ///< union-find over provisional labels; root <= label
  std::vector<uint32_t> parent;  ///< provisional label of the run left of each label's first run
};

/// Labels both colours in one pass over the runs and finds what contains what.
/// Paper: section 4.2 (topological filtering); the containment rule is that of Lemaitre, Maurice
/// and Lacassagne: the component left of a component's first run contains it. Blocks above the
/// noise limit (host/pipeline.h) are black.
void Label(const BitImage& bits, LabelWorkspace* workspace, Components* components);

/// See Backend::Measure.
void Measure(const Components& components, const uint32_t* slot, size_t slots, Feature* features);

}  // namespace topotag::scalar

#endif  // TOPOTAG_FALLBACK_LABEL_H_
