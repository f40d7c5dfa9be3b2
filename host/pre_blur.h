#ifndef TOPOTAG_HOST_PRE_BLUR_H_
#define TOPOTAG_HOST_PRE_BLUR_H_

#include <cstddef>
#include <cstdint>

#include "host/buffer.h"
#include "topotag/image.h"

namespace topotag {

/// Memory of PreBlur, kept between frames; holds the result.
struct PreBlurWorkspace {
  Buffer<uint8_t> padded;  ///< one row with its border
  Buffer<uint16_t> rows;   ///< the last five, summed along x
  Buffer<uint8_t> pixels;
};

/// Smooths by the 5 x 5 binomial filter, (1 4 6 4 1) along x and y, rounded to nearest: a Gaussian
/// of sigma 1 px, which leaves 0.27 of white noise. Paper: section 5, images with severe noise are
/// smoothed by a 5 x 5 kernel. Border: replicated.
/// Highway kernel, dispatched at run time; tests/pre_blur_test.cc has its scalar reference.
/// @return a view of workspace->pixels.
ImageView PreBlur(const ImageView& image, PreBlurWorkspace* workspace);

/// Contrast that the noise of a smoothed frame alone gives a tile, grey levels: above the spans of
/// a quarter of all tiles.
int NoiseContrast(const ImageView& image);

}  // namespace topotag

#endif  // TOPOTAG_HOST_PRE_BLUR_H_
