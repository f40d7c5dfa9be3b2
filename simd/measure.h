#ifndef TOPOTAG_SIMD_MEASURE_H_
#define TOPOTAG_SIMD_MEASURE_H_

#include <cstddef>
#include <cstdint>

#include "host/buffer.h"
#include "host/pipeline.h"

namespace topotag {
class Workers;
}

namespace topotag::simd {

/// Sums of one component in the making.
struct alignas(32) PartialFeature {
  int64_t sums[2];    ///< of x and of y
  int16_t limits[4];  ///< largest of -1 - x, -1 - y, x, y
  uint32_t area;
};

/// Memory of Measure, kept between frames.
struct MeasureWorkspace {
  Buffer<PartialFeature> partial;  ///< of every slot for the first task, then for the next one
};

/// Equals scalar::Measure.
void Measure(const Components& components, const uint32_t* slot, size_t slots, Workers* workers,
             MeasureWorkspace* workspace, Feature* features);

}  // namespace topotag::simd

#endif  // TOPOTAG_SIMD_MEASURE_H_
