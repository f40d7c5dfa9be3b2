#ifndef TOPOTAG_SIMD_THRESHOLD_H_
#define TOPOTAG_SIMD_THRESHOLD_H_

#include <cstdint>
#include <vector>

#include "fallback/threshold.h"
#include "host/buffer.h"
#include "host/pipeline.h"
#include "topotag/image.h"

namespace topotag {
class Workers;
}

namespace topotag::simd {

/// One level of the push-pull pyramid. Rows are padded with cells without a value, so that vectors
/// need no tail.
struct ThresholdLevel {
  int cols, rows;
  int stride;     ///< cells from one row to the next
  size_t offset;  ///< of its first cell in ThresholdWorkspace::cells
};

/// Memory of ThresholdMap, kept between frames.
struct ThresholdWorkspace {
  int stride = 0;                          ///< bytes from one row of tiles or corners to the next
  Buffer<uint8_t> tile_min, tile_max;      ///< with a border of one tile that is neutral
  Buffer<uint8_t> corner_min, corner_max;  ///< of one row
  Buffer<uint8_t> floor, ceiling;          ///< of one row of tiles
  Buffer<int16_t> cells;
  std::vector<ThresholdLevel> levels;
  scalar::ThresholdWorkspace paper;
};

/// Equals scalar::ThresholdMap. The map of the preset `paper` is computed by that function itself.
void ThresholdMap(const ImageView& image, const ThresholdParams& params, Workers* workers,
                  ThresholdWorkspace* workspace, ThresholdGrid* grid);

}  // namespace topotag::simd

#endif  // TOPOTAG_SIMD_THRESHOLD_H_
