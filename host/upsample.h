#ifndef TOPOTAG_HOST_UPSAMPLE_H_
#define TOPOTAG_HOST_UPSAMPLE_H_

#include <cstdint>
#include <vector>

#include "topotag/image.h"

namespace topotag {

/// Memory of Upsample, kept between frames; holds the result.
struct UpsampleWorkspace {
  std::vector<int16_t> rows;
  std::vector<uint8_t> pixels;
};

/// Doubles both sides by cubic convolution (Catmull-Rom), rounded to nearest: pixel (x, y) of the
/// result lies at ((x + 0.5) / 2 - 0.5, (y + 0.5) / 2 - 0.5) of `image`. Border: replicated.
/// @return a view of workspace->pixels.
ImageView Upsample(const ImageView& image, UpsampleWorkspace* workspace);

}  // namespace topotag

#endif  // TOPOTAG_HOST_UPSAMPLE_H_
