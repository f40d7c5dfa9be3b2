#ifndef TOPOTAG_HOST_LEVELS_H_
#define TOPOTAG_HOST_LEVELS_H_

#include <cstdint>

#include "topotag/image.h"

namespace topotag {

/// Places in the image are in pixels times 2^15, which leaves room for the image's size and as much
/// beyond it in 32 bits.
inline constexpr int kPlaceShift = 15;

/// 16 points on the outline of a parallelogram, 4 on each side: at (a, b) = (+-4, k) and (k, +-4),
/// k = -3, -1, 1, 3, they lie at (x, y) + a u + b v.
struct Ring {
  int32_t x, y;
  int32_t ux, uy, vx, vy;
};

inline constexpr int kRingPoints = 16;

/// Sums of the bilinear grey levels at a ring's points, times 2^8, rounded down for each point; and
/// of them times a and b. Points outside the image take the nearest pixel of its border.
struct RingSums {
  int32_t sum, a, b;
};

/// The sums of `count` rings.
/// Highway kernel, dispatched at run time; tests/centroid_test.cc has its scalar reference.
void SumRings(const ImageView& image, const Ring* rings, int count, RingSums* sums);

/// The bilinear grey levels at `count` places, times 2^8, as SumRings.
/// @param x, y  padded to a multiple of kRingPoints with any places; so is `levels`
void SampleLevels(const ImageView& image, const int32_t* x, const int32_t* y, int count,
                  int32_t* levels);

}  // namespace topotag

#endif  // TOPOTAG_HOST_LEVELS_H_
