#ifndef TOPOTAG_SIMD_RUNS_H_
#define TOPOTAG_SIMD_RUNS_H_

#include <cstddef>

#include "host/pipeline.h"

namespace topotag {
class Workers;
}

namespace topotag::simd {

/// Bounds before a row's first and behind its last one that can be read: -2 and kOutsideBound.
inline constexpr int kBoundsBefore = 1;
inline constexpr int kBoundsBehind = 2;

/// First step of the labelling: the runs of every row, without the blocks above the noise limit.
/// Fills width, height, row_begin, row_runs and bound, and reserves label. The rows of each band of
/// kBlockRows rows follow one another in a region of the band's own, so that bands are independent.
void FindRuns(const BitImage& bits, Workers* workers, Components* components);

}  // namespace topotag::simd

#endif  // TOPOTAG_SIMD_RUNS_H_
