#ifndef TOPOTAG_HOST_SAMPLE_H_
#define TOPOTAG_HOST_SAMPLE_H_

#include <algorithm>

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
  LocalMap(const TagMap& map, Point2 tag) : center(map.Pixel(tag, &j)) {}

  Point2 At(Point2 offset) const {
    return {center.x + j[0] * offset.x + j[1] * offset.y,
            center.y + j[2] * offset.x + j[3] * offset.y};
  }
  double Determinant() const { return j[0] * j[3] - j[1] * j[2]; }

  Jacobian2 j;
  Point2 center;
};

/// White or black that varies linearly: grey level at a point, and its change per unit of u and v.
struct Shade {
  double level = 0;
  Point2 gradient;
};

/// Least-squares plane through the grey levels on the outline of the rectangle with half sides
/// `half`, in units, around the centre.
inline Shade RingShade(const ImageView& image, const LocalMap& map, Point2 half) {
  constexpr int kPerSide = 6;
  double sum = 0;
  Point2 moment;
  Point2 square;
  for (int i = 0; i < kPerSide; ++i) {
    const double along = (2.0 * i + 1) / kPerSide - 1;
    const double x = half.x * along;
    const double y = half.y * along;
    // The four points are symmetric to the centre in pairs: mean and gradient are independent.
    for (const Point2 p : {Point2{x, -half.y}, {half.x, y}, {-x, half.y}, {-half.x, -y}}) {
      const double grey = Bilinear(image, map.At(p));
      sum += grey;
      moment = {moment.x + grey * p.x, moment.y + grey * p.y};
      square = {square.x + p.x * p.x, square.y + p.y * p.y};
    }
  }
  return {sum / (4 * kPerSide), {moment.x / square.x, moment.y / square.y}};
}

/// Mean grey level on that outline.
inline double RingLevel(const ImageView& image, const LocalMap& map, Point2 half) {
  return RingShade(image, map, half).level;
}

}  // namespace topotag

#endif  // TOPOTAG_HOST_SAMPLE_H_
