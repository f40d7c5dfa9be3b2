#ifndef TOPOTAG_FALLBACK_THRESHOLD_H_
#define TOPOTAG_FALLBACK_THRESHOLD_H_

#include <cstdint>
#include <vector>

#include "host/pipeline.h"
#include "topotag/image.h"

namespace topotag::scalar {

/// Memory of ThresholdMap, kept between frames.
struct ThresholdWorkspace {
  std::vector<uint8_t> tile_min, tile_max;
  std::vector<uint8_t> corner_min, corner_max;
  std::vector<uint16_t> pyramid;
  std::vector<uint8_t> blocks;
};

/// Threshold map: image -> thresholds at tile corners. Paper: section 4.1.
///
/// kDefault: the threshold of a corner with contrast lies contrast_sixteenths of the way from the
/// darkest to the brightest grey level of its four tiles; corners without contrast take the largest
/// one near them (push-pull). A tile without contrast is all of one colour. kPaper: means of the
/// image reduced by s1, clamped from below at alpha, over w x w,
/// every s2-th, times the bin factor and not below beta. Border: tiles and blocks at the right and
/// bottom hold the pixels that exist.
void ThresholdMap(const ImageView& image, const ThresholdParams& params,
                  ThresholdWorkspace* workspace, ThresholdGrid* grid);

}  // namespace topotag::scalar

#endif  // TOPOTAG_FALLBACK_THRESHOLD_H_
