#ifndef TOPOTAG_HOST_MEAN_SIDE_H_
#define TOPOTAG_HOST_MEAN_SIDE_H_

#include <cmath>

#include "topotag/geometry.h"

namespace topotag {

/// Mean length of the four sides of a quadrilateral: the size that Options::min_size speaks of.
inline double MeanSide(const Point2* corners) {
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const Point2 &a = corners[i], &b = corners[(i + 1) % 4];
    sum += std::sqrt((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y));
  }
  return sum / 4;
}

/// What seems to be smaller than this part of the least size, before it is measured, surely is.
inline constexpr double kSurelySmaller = 0.8;

}  // namespace topotag

#endif  // TOPOTAG_HOST_MEAN_SIDE_H_
