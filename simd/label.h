#ifndef TOPOTAG_SIMD_LABEL_H_
#define TOPOTAG_SIMD_LABEL_H_

#include <cstdint>
#include <vector>

#include "host/buffer.h"
#include "host/pipeline.h"

namespace topotag {
class Workers;
}

namespace topotag::simd {

/// Rows that are labelled by one thread, with labels of their own.
struct Strip {
  int row_begin, row_end;
  Components::Range labels;
};

/// Memory of Label, kept between frames.
struct LabelWorkspace {
  std::vector<Strip> strips;
  std::vector<uint32_t> merged;  ///< labels that were joined with one of an earlier strip
};

/// Equals scalar::Label, but for which numbers serve as labels. Run-based, both colours in one pass
/// over the rows; where the runs of two rows correspond one to one, whole vectors of labels are
/// copied (Lemaitre, Maurice and Lacassagne 2021, for the containment).
void Label(const BitImage& bits, Workers* workers, LabelWorkspace* workspace,
           Components* components);

}  // namespace topotag::simd

#endif  // TOPOTAG_SIMD_LABEL_H_
