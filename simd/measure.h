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

/// Memory of Measure, kept between frames.
struct MeasureWorkspace {
  Buffer<Feature> partial;  ///< the features of each task but the first
};

/// Equals scalar::Measure.
void Measure(const Components& components, const uint32_t* slot, size_t slots, Workers* workers,
             MeasureWorkspace* workspace, Feature* features);

}  // namespace topotag::simd

#endif  // TOPOTAG_SIMD_MEASURE_H_
