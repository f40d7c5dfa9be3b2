#ifndef TOPOTAG_FALLBACK_BINARIZE_H_
#define TOPOTAG_FALLBACK_BINARIZE_H_

#include <cstdint>

#include "host/pipeline.h"
#include "topotag/image.h"

namespace topotag::scalar {

/// Thresholds of the pixels of row y: out[x] for x in [0, width). Bilinear in the grid, in fixed
/// point; the kRowsPerThreshold rows of a group share the thresholds of the group's middle.
void ThresholdRow(const ThresholdGrid& grid, int y, int width, uint8_t* out);

/// Binarization: a pixel is white where its grey level is not below its threshold.
/// Paper: section 4.1.
void Binarize(const ImageView& image, const ThresholdGrid& grid, BitImage* bits);

}  // namespace topotag::scalar

#endif  // TOPOTAG_FALLBACK_BINARIZE_H_
