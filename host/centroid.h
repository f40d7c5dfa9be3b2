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

/// Bounds of DarknessPatch::black, and of g * inverse_white / 2^8 wherever a pixel has weight.
inline constexpr int kMaxBlack = 1 << 13;
inline constexpr int kMaxRelative = 10900;

inline constexpr int kMaxStep = 32;

/// Columns that share their rows where not all rows of a patch count.
inline constexpr int kGroupColumns = 32;

/// The lowest bits of `index` in reverse order: below `size`, a power of 2.
inline int ReversedBits(int index, int size) {
  int reversed = 0;
  for (int bit = 1; bit < size; bit *= 2, index /= 2) reversed = 2 * reversed + index % 2;
  return reversed;
}

/// The pixels of a dark shape, and how each counts. All numbers are integers, so that sums over
/// them are the same on every target, in whatever order they are taken.
struct DarknessPatch {
  int x, y;                   ///< of the first pixel, in the image
  int width = 0, height = 0;  ///< pixels, within the image
  /// A power of 2, <= kMaxStep. Of group g of kGroupColumns columns the rows r, r + step .. count,
  /// r = ReversedBits(g, step): neighbouring groups take other rows, so that an edge along the rows
  /// is seen as sharply as one across them. The sums are multiplied by the step.
  int step = 1;
  /// Distances from two centre lines, pixels times `one`. A pixel's weight is the product over
  /// both of its distance inside `reach_u`, `reach_v`, between 0 and `one`. Beyond the reach, and
  /// up to 32 pixels left and right of the patch, neither may wrap around.
  LinearValue u, v;
  int16_t reach_u, reach_v;
  int16_t one;  ///< a power of 2, <= 128
  /// 2^8 black / white: a pixel of grey level g has the darkness black - g * inverse_white / 2^8.
  LinearValue inverse_white;
  int16_t black;  ///< a power of 2, <= kMaxBlack
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

/// Highway's name of the target that the kernels run on.
const char* CentroidTargetName();

}  // namespace topotag

#endif  // TOPOTAG_HOST_CENTROID_H_
