#ifndef TOPOTAG_HOST_CENTROID_H_
#define TOPOTAG_HOST_CENTROID_H_

#include <cstdint>

#include "topotag/image.h"

namespace topotag {

/// A 16-bit value that is linear in the pixel: ((base + y dy) >> 8) + ((x dx + 128) >> 8), x and y
/// from the first pixel of the patch, shifts rounding down; what does not fit 16 bits wraps around.
struct LinearValue {
  int32_t base, dx, dy;
};

/// The pixels of a dark shape, and how each counts. All numbers are integers, so that sums over
/// them are the same on every target, in whatever order they are taken.
struct DarknessPatch {
  int x, y;                   ///< of the first pixel in the image
  int width = 0, height = 0;  ///< pixels, within the image
  /// Distances from two centre lines, pixels times `one`. A pixel's weight is the product over
  /// both of its distance inside `reach_u`, `reach_v`, between 0 and `one`. Beyond the reach, and
  /// up to 32 pixels left and right of the patch, neither may wrap around.
  LinearValue u, v;
  int16_t reach_u, reach_v;
  int16_t one;  ///< a power of 2, <= 128
  /// 2^8 black / white: a pixel of grey level g has the darkness black - g / white.
  LinearValue inverse_white;
  int16_t black;  ///< a power of 2, <= 2^14: g * inverse_white / 2^8 must fit 16 bits
};

/// Sums over the patch of s = weight * darkness / 2^15, rounded for each pixel, and of s times
/// its place in the patch.
struct DarknessSums {
  int64_t sum = 0;
  int64_t x = 0;
  int64_t y = 0;
};

/// The sums of `count` patches; those of a patch with no pixels are 0.
/// Highway kernel, dispatched at run time; tests/centroid_test.cc has its scalar reference.
void SumDarkness(const ImageView& image, const DarknessPatch* patches, int count,
                 DarknessSums* sums);

/// 16 points on the outline of a parallelogram, 4 on each side: at (a, b) = (+-4, k) and (k, +-4),
/// k = -3, -1, 1, 3, they lie at centre + a u + b v. Pixels times 2^15, which the image's size
/// and what lies beyond must leave room for in 32 bits.
struct Ring {
  int32_t ux, uy, vx, vy;
};

inline constexpr int kRingPoints = 16;
inline constexpr int kRingShift = 15;

/// Sums of the bilinear grey levels at a ring's points, times 2^8, rounded down for each point; and
/// of them times a and b. Points outside the image take the nearest pixel of its border.
struct RingSums {
  int32_t sum, a, b;
};

/// As SumDarkness.
void SumRings(const ImageView& image, int32_t x, int32_t y, const Ring rings[2], RingSums sums[2]);

/// Highway's name of the target that the kernels run on.
const char* CentroidTargetName();

}  // namespace topotag

#endif  // TOPOTAG_HOST_CENTROID_H_
