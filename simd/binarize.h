#ifndef TOPOTAG_SIMD_BINARIZE_H_
#define TOPOTAG_SIMD_BINARIZE_H_

#include "host/pipeline.h"
#include "topotag/image.h"

namespace topotag {
class Workers;
}

namespace topotag::simd {

/// Equals scalar::Binarize.
void Binarize(const ImageView& image, const ThresholdGrid& grid, Workers* workers, BitImage* bits);

}  // namespace topotag::simd

#endif  // TOPOTAG_SIMD_BINARIZE_H_
