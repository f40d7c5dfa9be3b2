#ifndef TOPOTAG_SIMD_RUNS_H_
#define TOPOTAG_SIMD_RUNS_H_

#include <cstdint>

#include "host/buffer.h"
#include "host/pipeline.h"

namespace topotag {
class Workers;
}

namespace topotag::simd {

/// Memory of FindRuns, kept between frames, and its second result.
struct RunsWorkspace {
  Buffer<uint64_t> changes;  ///< bits that differ from their left neighbour, of every row
  Buffer<int16_t> rank;      ///< of every bound, as Components::bound
};

/// First step of the labelling: the runs of every row, without the blocks above the noise limit.
/// Fills width, height, row_begin, row_runs and bound, and reserves label. The rows of each band of
/// kBlockRows rows follow one another in a region of the band's own, so that bands are independent.
///
/// rank, for every bound but those of the first row, is the run of the row above that holds the
/// bound's own pixel where a white run begins, and the pixel to the left of it where a black one
/// does. So run k, widened by a pixel on both sides if it is black, lies below the runs rank[k] to
/// rank[k + 1] of the row above.
void FindRuns(const BitImage& bits, Workers* workers, RunsWorkspace* workspace,
              Components* components);

}  // namespace topotag::simd

#endif  // TOPOTAG_SIMD_RUNS_H_
