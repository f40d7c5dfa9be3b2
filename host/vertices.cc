#include "host/vertices.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/sample.h"

namespace topotag {
namespace {

constexpr double kMinDelta = 2;     // pixels
constexpr double kCellHalf = 2;     // half the pitch, units
constexpr double kMinContrast = 4;  // grey levels, mean over the ideal shape

// The shape that a vertex is the centre of.
struct Shape {
  double half;           // of its side, units
  double ring;           // half side of the square in the middle of the gap around it, units
  double second_moment;  // mean of x^2 over its area, square units
};

// Weighted centroid of level - grey over the support, in pixels relative to the map's centre. The
// support is a parallelogram: weight 1 inside, falling to 0 over the outermost `edge` units.
// @param sign  1 for a dark shape, -1 for a bright one
bool Centroid(const ImageView& image, const LocalMap& map, double half, double edge, double level,
              double sign, double min_signal, Point2* offset) {
  const Jacobian2& j = map.j;
  const double extent_x = half * (std::abs(j[0]) + std::abs(j[1]));
  const double extent_y = half * (std::abs(j[2]) + std::abs(j[3]));
  const int x0 = std::max(static_cast<int>(std::ceil(map.center.x - extent_x)), 0);
  const int x1 = std::min(static_cast<int>(std::floor(map.center.x + extent_x)), image.width - 1);
  const int y0 = std::max(static_cast<int>(std::ceil(map.center.y - extent_y)), 0);
  const int y1 = std::min(static_cast<int>(std::floor(map.center.y + extent_y)), image.height - 1);
  // Weight along one axis: how far inside the support, in edge widths.
  const double scale = 1 / (map.Determinant() * edge);
  const double inside = half / edge;
  double sum = 0;
  double sum_x = 0;
  double sum_y = 0;
  for (int y = y0; y <= y1; ++y) {
    const uint8_t* row = image.row(y);
    const double dy = y - map.center.y;
    for (int x = x0; x <= x1; ++x) {
      const double dx = x - map.center.x;
      const double u = inside - std::abs((j[3] * dx - j[1] * dy) * scale);
      const double v = inside - std::abs((j[0] * dy - j[2] * dx) * scale);
      if (u <= 0 || v <= 0) continue;
      const double signal = std::min(u, 1.0) * std::min(v, 1.0) * (level - row[x]);
      sum += signal;
      sum_x += signal * dx;
      sum_y += signal * dy;
    }
  }
  if (!(sign * sum > min_signal)) return false;
  *offset = {sum_x / sum, sum_y / sum};
  return true;
}

// Centroid of the projected shape minus the projection of its centre, to second order, for a
// homography h and a shape with equal second moments in x and y. With the point x(u, v) = N / w
// and the area element |J| ~ w^-3, the mean of x |J| over the shape over the mean of |J| is
// x + m (x_uu / 2 + x_vv / 2 + x_u (ln |J|)_u + x_v (ln |J|)_v), where x_uu = -2 (h31 / w) x_u and
// (ln |J|)_u = -3 h31 / w.
Point2 PerspectiveBias(const Homography& ideal, Point2 tag, const Jacobian2& j, double m) {
  const double scale = -4 * m / ideal.Denominator(tag);
  const double gu = scale * ideal.m[2][0];
  const double gv = scale * ideal.m[2][1];
  return {gu * j[0] + gv * j[1], gu * j[2] + gv * j[3]};
}

// The vertex at model point `tag`.
Point2 MeasureVertex(const ImageView& image, const TagMap& tag_map, Point2 tag, const Shape& shape,
                     double sign) {
  LocalMap map(tag_map, tag);
  const Point2 expected = map.center;
  const Point2 bias = PerspectiveBias(tag_map.ideal, tag, map.j, shape.second_moment);
  map.center = {expected.x + bias.x, expected.y + bias.y};
  const double pixel_area = std::abs(map.Determinant());  // of a square unit
  const double unit = std::sqrt(pixel_area);              // pixels
  const double delta =
      std::min(std::max(kMinDelta / unit, 2 * shape.half / 10), shape.ring - shape.half);
  const double level = RingLevel(image, map, shape.ring);
  const double min_signal = kMinContrast * 4 * shape.half * shape.half * pixel_area;
  Point2 offset;
  if (!Centroid(image, map, shape.half + delta, delta, level, sign, min_signal, &offset)) {
    return expected;
  }
  return {expected.x + offset.x, expected.y + offset.y};
}

}  // namespace

void RefineVertices(const ImageView& image, const Decoded& decoded, VertexList* vertices) {
  const int n = decoded.family.n();
  // Second moment of a node from its area: a square of area A has A / 12, circle and hexagon
  // almost the same.
  const Shape node{1.5, kCellHalf, std::clamp(decoded.node_area, 7.0, 9.0) / 12};
  const Shape hole{0.5, 1.0, 1.0 / 12};
  vertices->resize(n * n);
  for (int i = 0; i < n * n; ++i) {
    (*vertices)[i] =
        MeasureVertex(image, decoded.map, ModelVertex(n, i), i < 2 ? hole : node, i < 2 ? -1 : 1);
  }
}

bool RefitMap(const VertexList& vertices, Decoded* decoded) {
  const int n = decoded->family.n();
  std::array<Point2, kMaxVertices> model;
  std::array<Point2, kMaxVertices> ideal;
  std::array<double, kMaxVertices> weight;
  for (int i = 0; i < n * n; ++i) {
    const auto k = static_cast<size_t>(i);
    model[k] = ModelVertex(n, i);
    weight[k] = i < 2 ? kHoleWeight : 1;
    if (!PixelToIdeal(decoded->map.camera, vertices[i], &ideal[k])) return false;
  }
  return FitHomography(model.data(), ideal.data(), weight.data(), n * n, &decoded->map.ideal);
}

}  // namespace topotag
