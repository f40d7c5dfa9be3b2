#include "host/vertices.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/sample.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

// A support that is off by some tenths of a pixel pulls the centroid by a twentieth of that: the
// second pass starts from where the first one ended.
constexpr int kPasses = 2;
constexpr double kMinDelta = 2;     // pixels
constexpr double kHalfGap = 0.5;    // units
constexpr double kMinSignal = 0.2;  // of the signal of an unblurred shape
constexpr double kMaxOffset = 0.5;  // from the expected place, units

// A dark shape with gaps around it. Lengths in units.
struct Shape {
  Point2 half;           // of its sides
  Point2 second_moment;  // mean of x^2 and of y^2 over its area
};

// The shapes of a marker's nodes. Their second moments lie between those of circles and squares,
// where the area of a node says; hexagons fit in between.
struct NodeShapes {
  explicit NodeShapes(double node_area) {
    constexpr double kCircle = 7.07;
    constexpr double kSquare = 9;
    const double t = std::clamp((node_area - kCircle) / (kSquare - kCircle), 0.0, 1.0);
    const auto mix = [&](double circle, double square) { return circle + t * (square - circle); };
    solid.second_moment = {mix(0.5625, 0.75), mix(0.5625, 0.75)};
    ring.second_moment = {mix(0.625, 0.8333), mix(0.625, 0.8333)};
    baseline.second_moment = {mix(1.845, 2.238), mix(0.676, 0.8525)};
  }

  Shape solid{{1.5, 1.5}, {}};
  Shape ring{{1.5, 1.5}, {}};
  Shape baseline{{2.5, 1.5}, {}};
};

// Weighted centroid of level - grey over the support, in pixels relative to the map's centre. The
// support is a parallelogram of half sides `half`, its edge smoothed over one pixel.
// @param signal  the sum of the weights times level - grey, in pixels times grey levels
bool Centroid(const ImageView& image, const LocalMap& map, Point2 half, double level,
              double min_signal, Point2* offset) {
  const Jacobian2& j = map.j;
  const double det = map.Determinant();
  // Pixels across which each coordinate grows by one unit.
  const double pitch_u = std::abs(det) / std::hypot(j[3], j[1]);
  const double pitch_v = std::abs(det) / std::hypot(j[0], j[2]);
  const double reach_u = half.x + 0.5 / pitch_u;
  const double reach_v = half.y + 0.5 / pitch_v;
  const double extent_x = reach_u * std::abs(j[0]) + reach_v * std::abs(j[1]);
  const double extent_y = reach_u * std::abs(j[2]) + reach_v * std::abs(j[3]);
  const int x0 = std::max(static_cast<int>(std::ceil(map.center.x - extent_x)), 0);
  const int x1 = std::min(static_cast<int>(std::floor(map.center.x + extent_x)), image.width - 1);
  const int y0 = std::max(static_cast<int>(std::ceil(map.center.y - extent_y)), 0);
  const int y1 = std::min(static_cast<int>(std::floor(map.center.y + extent_y)), image.height - 1);
  const double scale_u = pitch_u / det;
  const double scale_v = pitch_v / det;
  double sum = 0;
  double sum_x = 0;
  double sum_y = 0;
  for (int y = y0; y <= y1; ++y) {
    const uint8_t* row = image.row(y);
    const double dy = y - map.center.y;
    for (int x = x0; x <= x1; ++x) {
      const double dx = x - map.center.x;
      // How far inside the support, in pixels.
      const double u = reach_u * pitch_u - std::abs((j[3] * dx - j[1] * dy) * scale_u);
      const double v = reach_v * pitch_v - std::abs((j[0] * dy - j[2] * dx) * scale_v);
      if (u <= 0 || v <= 0) continue;
      const double signal = std::min(u, 1.0) * std::min(v, 1.0) * (level - row[x]);
      sum += signal;
      sum_x += signal * dx;
      sum_y += signal * dy;
    }
  }
  if (!(sum > min_signal)) return false;
  *offset = {sum_x / sum, sum_y / sum};
  return true;
}

// Centroid of the projected shape minus the projection of its centre, to second order, for a
// homography h and a shape symmetric in u and v with second moments m. With the point
// x(u, v) = N / w and the area element |J| ~ w^-3, the mean of x |J| over the shape over the mean
// of |J| is x + sum over u, v of m_u (x_uu / 2 + x_u (ln |J|)_u), where x_uu = -2 (h31 / w) x_u and
// (ln |J|)_u = -3 h31 / w.
Point2 PerspectiveBias(const Homography& ideal, Point2 tag, const Jacobian2& j, Point2 m) {
  const double scale = -4 / ideal.Denominator(tag);
  const double gu = scale * m.x * ideal.m[2][0];
  const double gv = scale * m.y * ideal.m[2][1];
  return {gu * j[0] + gv * j[1], gu * j[2] + gv * j[3]};
}

// Measured place of the shape's centre, the model's point `tag`, pixels; where `tag_map` takes it
// if there is too little contrast.
Point2 MeasureCenter(const ImageView& image, const TagMap& tag_map, Point2 tag,
                     const Shape& shape) {
  LocalMap map(tag_map, tag);
  const Point2 expected = map.center;
  const Point2 bias = PerspectiveBias(tag_map.ideal, tag, map.j, shape.second_moment);
  map.center = {expected.x + bias.x, expected.y + bias.y};
  const double unit = std::sqrt(std::abs(map.Determinant()));  // pixels
  const double side = 2 * shape.half.y;
  const double delta = std::min(std::max(kMinDelta / unit, side / 10), kHalfGap);
  const double level = RingLevel(image, map, {shape.half.x + kHalfGap, shape.half.y + kHalfGap});
  const double contrast =
      level - RingLevel(image, map, {shape.half.x - kHalfGap, shape.half.y - kHalfGap});
  const double full_signal = 4 * shape.half.x * shape.half.y * unit * unit * contrast;
  Point2 offset;
  if (!(contrast > 0) ||
      !Centroid(image, map, {shape.half.x + delta, shape.half.y + delta}, level,
                kMinSignal * full_signal, &offset) ||
      !(std::hypot(offset.x, offset.y) < kMaxOffset * unit)) {
    return expected;
  }
  return {expected.x + offset.x, expected.y + offset.y};
}

Point2 BaselineCenter(int n) {
  const Point2 p1 = ModelVertex(n, 0);
  return {p1.x + 1, p1.y};
}

// What is measured of a marker: the baseline node as a whole, then the nodes from vertex 2 on.
struct Measured {
  int count = 0;
  std::array<Point2, kMaxVertices> model;
  std::array<Point2, kMaxVertices> pixel;
};

// Measures all nodes at the places that decoded->map takes them to, and refits the map to them.
void MeasureNodes(const ImageView& image, const NodeShapes& shapes, Decoded* decoded,
                  Measured* measured) {
  const int n = decoded->family.n();
  TagMap& map = decoded->map;
  std::array<Point2, kMaxVertices> ideal;
  bool inside_lens = true;
  measured->count = n * n - 1;
  for (int i = 0; i < measured->count; ++i) {
    const auto k = static_cast<size_t>(i);
    const Point2 model = i == 0 ? BaselineCenter(n) : ModelVertex(n, i + 1);
    const bool has_hole = i > 0 && IdBit(decoded->family, decoded->id, i + 1);
    const Shape& shape = i == 0 ? shapes.baseline : has_hole ? shapes.ring : shapes.solid;
    measured->model[k] = model;
    measured->pixel[k] = MeasureCenter(image, map, model, shape);
    inside_lens = inside_lens && PixelToIdeal(map.camera, measured->pixel[k], &ideal[k]);
  }
  Homography refined;
  if (inside_lens &&
      FitHomography(measured->model.data(), ideal.data(), nullptr, measured->count, &refined)) {
    map.ideal = refined;
  }
}

}  // namespace

void RefineVertices(const ImageView& image, Decoded* decoded, VertexList* vertices) {
  const int n = decoded->family.n();
  const NodeShapes shapes(decoded->node_area);
  Measured measured;
  for (int pass = 0; pass < kPasses; ++pass) MeasureNodes(image, shapes, decoded, &measured);

  vertices->resize(n * n);
  const Point2 expected = decoded->map.Pixel(measured.model[0]);
  for (int i = 0; i < 2; ++i) {
    const Point2 p = decoded->map.Pixel(ModelVertex(n, i));
    (*vertices)[i] = {p.x + measured.pixel[0].x - expected.x,
                      p.y + measured.pixel[0].y - expected.y};
  }
  std::copy(measured.pixel.begin() + 1, measured.pixel.begin() + measured.count,
            vertices->begin() + 2);
}

}  // namespace topotag
