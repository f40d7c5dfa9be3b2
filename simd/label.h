#ifndef TOPOTAG_SIMD_LABEL_H_
#define TOPOTAG_SIMD_LABEL_H_

#include <cstdint>
#include <vector>

#include "host/pipeline.h"
#include "simd/runs.h"

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
  RunsWorkspace runs;
  std::vector<Strip> strips;
  std::vector<uint32_t> merged;  ///< labels that were joined with one of an earlier strip
};

/// Equals scalar::Label, but for which numbers serve as labels. Run-based, both colours in one pass
/// over the rows, a vector of runs at a time: most take the label of the one run above that they
/// touch. Containment: Lemaitre, Maurice and Lacassagne 2021.
void Label(const BitImage& bits, Workers* workers, LabelWorkspace* workspace,
           Components* components);

}  // namespace topotag::simd

#endif  // TOPOTAG_SIMD_LABEL_H_
