#ifndef TOPOTAG_HOST_SAMPLE_H_
#define TOPOTAG_HOST_SAMPLE_H_

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/centroid.h"
#include "host/homography.h"
#include "topotag/image.h"

namespace topotag {

/// Grey level at a point in pixels, bilinear; points outside take the nearest pixel of the border,
/// a point that is not a number the first pixel.
inline double Bilinear(const ImageView& image, Point2 p) {
  const double x = p.x > 0 ? std::min(p.x, image.width - 1.0) : 0;
  const double y = p.y > 0 ? std::min(p.y, image.height - 1.0) : 0;
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, image.width - 1);
  const uint8_t* upper = image.row(y0);
  const uint8_t* lower = image.row(std::min(y0 + 1, image.height - 1));
  const double fx = x - x0;
  const double fy = y - y0;
  return (upper[x0] * (1 - fx) + upper[x1] * fx) * (1 - fy) +
         (lower[x0] * (1 - fx) + lower[x1] * fx) * fy;
}

/// A tag map linearised at a point: pixel = center + j * (units from the point).
struct LocalMap {
  LocalMap() = default;
  LocalMap(const TagMap& map, Point2 tag) : center(map.Pixel(tag, &j)) {}

  double Determinant() const { return j[0] * j[3] - j[1] * j[2]; }

  Jacobian2 j;
  Point2 center;
};

/// Grey levels of a node: of the gap around it, with its change per unit of u and v, and of its
/// body. Single precision is a thousandth of what noise does to them.
struct NodeLevels {
  float white = 0;
  float white_u = 0, white_v = 0;
  float black = 0;
};

/// Nodes from this many pixels a square unit on are fine: the gradient of their gaps' white is
/// trusted, not only its level (host/vertices.cc), and there is room for three outlines in the gap.
inline constexpr double kFineArea = 64;
inline constexpr double kFineStep = 0.2;  // units from one of these outlines to the next

/// Least-squares plane through the grey levels on the outline of the rectangle with half sides
/// `gap`, in units, around the centre, and their mean on that with half sides `body`. All are 0
/// where the node is too large for a number of 32 bits or nowhere near the image.
inline NodeLevels MeasureLevels(const ImageView& image, const LocalMap& map, Point2 gap,
                                Point2 body) {
  constexpr double kOne = 1 << kRingShift;
  const Jacobian2& j = map.j;
  const double reach =
      (std::abs(j[0]) + std::abs(j[2])) * gap.x + (std::abs(j[1]) + std::abs(j[3])) * gap.y;
  if (!(reach < kMaxImageSide / 4 && std::abs(map.center.x) < kMaxImageSide &&
        std::abs(map.center.y) < kMaxImageSide)) {
    return {};
  }
  const auto fixed = [](double pixels) { return static_cast<int32_t>(pixels * kOne); };
  const auto ring = [&](Point2 half) {
    const double x = half.x / 4;
    const double y = half.y / 4;
    return Ring{fixed(j[0] * x), fixed(j[2] * x), fixed(j[1] * y), fixed(j[3] * y)};
  };
  const int32_t x = fixed(map.center.x);
  const int32_t y = fixed(map.center.y);
  RingSums sums[2];
  const Ring rings[2] = {ring(gap), ring(body)};
  SumRings(image, x, y, rings, sums);
  const double black = sums[1].sum;
  double white = sums[0].sum;
  int outlines = 1;
  // Sums of the levels times their place and of the squared places, in units. 168 is the sum of the
  // squares of a, and of b, which are in 4ths of a half side; the points are symmetric to the
  // centre in pairs, so that mean and gradient are independent.
  Point2 moment{sums[0].a * gap.x / 4, sums[0].b * gap.y / 4};
  Point2 square{gap.x * gap.x * 168 / 16, gap.y * gap.y * 168 / 16};
  if (std::abs(map.Determinant()) >= kFineArea) {
    const Point2 half[2] = {{gap.x - kFineStep, gap.y - kFineStep},
                            {gap.x + kFineStep, gap.y + kFineStep}};
    const Ring beside[2] = {ring(half[0]), ring(half[1])};
    SumRings(image, x, y, beside, sums);
    for (int i = 0; i < 2; ++i) {
      white += sums[i].sum;
      moment.x += sums[i].a * half[i].x / 4;
      moment.y += sums[i].b * half[i].y / 4;
      square.x += half[i].x * half[i].x * 168 / 16;
      square.y += half[i].y * half[i].y * 168 / 16;
    }
    outlines = 3;
  }
  constexpr double kLevel = 1.0 / 256;
  return {static_cast<float>(white * kLevel / (kRingPoints * outlines)),
          static_cast<float>(moment.x * kLevel / square.x),
          static_cast<float>(moment.y * kLevel / square.y),
          static_cast<float>(black * kLevel / kRingPoints)};
}

}  // namespace topotag

#endif  // TOPOTAG_HOST_SAMPLE_H_
