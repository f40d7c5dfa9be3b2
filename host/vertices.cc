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

// Weighted centroid of the darkness 1 - grey / white over the support, in pixels relative to the
// map's centre: relative to the shaded white, so that uneven light does not move it. The support is
// a parallelogram of half sides `half`, its edge smoothed over one pixel.
// @param min_signal  of the sum of the weighted darkness, pixels
bool Centroid(const ImageView& image, const LocalMap& map, Point2 half, const Shade& white,
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
  const Point2 slope{white.gradient.x / white.level, white.gradient.y / white.level};
  const double inverse_level = 1 / white.level;
  double sum = 0;
  double sum_x = 0;
  double sum_y = 0;
  for (int y = y0; y <= y1; ++y) {
    const uint8_t* row = image.row(y);
    const double dy = y - map.center.y;
    for (int x = x0; x <= x1; ++x) {
      const double dx = x - map.center.x;
      const double u = (j[3] * dx - j[1] * dy) / det;
      const double v = (j[0] * dy - j[2] * dx) / det;
      // How far inside the support, in pixels.
      const double inside_u = (reach_u - std::abs(u)) * pitch_u;
      const double inside_v = (reach_v - std::abs(v)) * pitch_v;
      if (inside_u <= 0 || inside_v <= 0) continue;
      // 1 / white to first order in the shading.
      const double shade = slope.x * u + slope.y * v;
      const double darkness = 1 - row[x] * inverse_level * (1 - shade);
      const double signal = std::min(inside_u, 1.0) * std::min(inside_v, 1.0) * darkness;
      sum += signal;
      sum_x += signal * dx;
      sum_y += signal * dy;
    }
  }
  if (!(sum > min_signal)) return false;
  *offset = {sum_x / sum, sum_y / sum};
  return true;
}

// Centroid of the projected shape minus the projection of its centre, to second order, for a shape
// symmetric in u and v with second moments m. The mean of the point x(u, v) over the image of the
// shape, whose area element is |J|, is x + sum over u, v of m_u (x_uu / 2 + x_u (ln |J|)_u). For a
// homography h with denominator w, |J| ~ w^-3, x_uu = -2 (h31 / w) x_u, (ln |J|)_u = -3 h31 / w.
Point2 HomographyBias(const Homography& ideal, Point2 tag, const Jacobian2& j, Point2 m) {
  const double scale = -4 / ideal.Denominator(tag);
  const double gu = scale * m.x * ideal.m[2][0];
  const double gv = scale * m.y * ideal.m[2][1];
  return {gu * j[0] + gv * j[1], gu * j[2] + gv * j[3]};
}

// The same with a lens: derivatives by differences over one unit.
Point2 LensBias(const TagMap& map, Point2 tag, const LocalMap& at, Point2 m) {
  Point2 bias;
  for (int axis = 0; axis < 2; ++axis) {
    const Point2 step = axis == 0 ? Point2{1, 0} : Point2{0, 1};
    const double moment = axis == 0 ? m.x : m.y;
    const LocalMap next(map, {tag.x + step.x, tag.y + step.y});
    const LocalMap previous(map, {tag.x - step.x, tag.y - step.y});
    const double growth = std::log(next.Determinant() / previous.Determinant()) / 2;
    const Point2 second{next.center.x + previous.center.x - 2 * at.center.x,
                        next.center.y + previous.center.y - 2 * at.center.y};
    bias.x += moment * (second.x / 2 + at.j[axis] * growth);
    bias.y += moment * (second.y / 2 + at.j[2 + axis] * growth);
  }
  return bias;
}

Point2 ShapeBias(const TagMap& map, Point2 tag, const LocalMap& at, Point2 m) {
  return map.HasLens() ? LensBias(map, tag, at, m) : HomographyBias(map.ideal, tag, at.j, m);
}

// Measured place of the shape's centre, the model's point `tag`, pixels; where `tag_map` takes it
// if there is too little contrast.
Point2 MeasureCenter(const ImageView& image, const TagMap& tag_map, Point2 tag,
                     const Shape& shape) {
  LocalMap map(tag_map, tag);
  const Point2 expected = map.center;
  const Point2 bias = ShapeBias(tag_map, tag, map, shape.second_moment);
  map.center = {expected.x + bias.x, expected.y + bias.y};
  const double unit = std::sqrt(std::abs(map.Determinant()));  // pixels
  const double side = 2 * shape.half.y;
  const double delta = std::min(std::max(kMinDelta / unit, side / 10), kHalfGap);
  const Shade white = RingShade(image, map, {shape.half.x + kHalfGap, shape.half.y + kHalfGap});
  const double black = RingLevel(image, map, {shape.half.x - kHalfGap, shape.half.y - kHalfGap});
  const double contrast = 1 - black / white.level;
  const double full_signal = 4 * shape.half.x * shape.half.y * unit * unit * contrast;
  Point2 offset;
  if (!(contrast > 0) ||
      !Centroid(image, map, {shape.half.x + delta, shape.half.y + delta}, white,
                kMinSignal * full_signal, &offset) ||
      !(std::hypot(offset.x, offset.y) < kMaxOffset * unit)) {
    return expected;
  }
  return {expected.x + offset.x, expected.y + offset.y};
}

Point2 BaselineCenter(Family family) {
  const Point2 p1 = ModelVertex(family, 0);
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
  const Family family = decoded->family;
  const uint64_t bits = VertexBits(family, decoded->id);
  TagMap& map = decoded->map;
  std::array<Point2, kMaxVertices> ideal;
  bool inside_lens = true;
  measured->count = family.node_count();
  for (int i = 0; i < measured->count; ++i) {
    const auto k = static_cast<size_t>(i);
    const Point2 model = i == 0 ? BaselineCenter(family) : ModelVertex(family, i + 1);
    const bool has_hole = (bits >> (i + 1) & 1) != 0;
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
  const NodeShapes shapes(decoded->node_area);
  Measured measured;
  for (int pass = 0; pass < kPasses; ++pass) MeasureNodes(image, shapes, decoded, &measured);

  vertices->resize(decoded->family.vertex_count());
  const Point2 expected = decoded->map.Pixel(measured.model[0]);
  for (int i = 0; i < 2; ++i) {
    const Point2 p = decoded->map.Pixel(ModelVertex(decoded->family, i));
    (*vertices)[i] = {p.x + measured.pixel[0].x - expected.x,
                      p.y + measured.pixel[0].y - expected.y};
  }
  std::copy(measured.pixel.begin() + 1, measured.pixel.begin() + measured.count,
            vertices->begin() + 2);
}

}  // namespace topotag
