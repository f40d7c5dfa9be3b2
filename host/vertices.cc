#include "host/vertices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/sample.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

// A support that is off by some tenths of a pixel pulls the centroid by a twentieth of that: the
// second pass starts from where the first one ended.
constexpr int kPasses = 2;
constexpr double kMinDelta = 2;  // pixels
// Largest gradient of the gaps' white by blur alone, per unit, at 1 pixel a unit; it falls with the
// square of the resolution.
constexpr double kBlurShading = 0.5;
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
  const auto pixel = [](double place, int size) {
    return static_cast<int>(std::clamp(place, 0.0, static_cast<double>(size)));
  };
  if (!std::isfinite(map.center.x + map.center.y + extent_x + extent_y)) return false;
  const int x0 = pixel(std::ceil(map.center.x - extent_x), image.width);
  const int x1 = pixel(std::floor(map.center.x + extent_x) + 1, image.width);
  const int y0 = pixel(std::ceil(map.center.y - extent_y), image.height);
  const int y1 = pixel(std::floor(map.center.y + extent_y) + 1, image.height);
  // The unit coordinates and 1 / white, to first order in the shading, are linear in the pixel.
  const Jacobian2 inverse{j[3] / det, -j[1] / det, -j[2] / det, j[0] / det};
  const Point2 slope{-white.gradient.x / (white.level * white.level),
                     -white.gradient.y / (white.level * white.level)};
  const double inverse_level = 1 / white.level;
  double sum = 0;
  double sum_x = 0;
  double sum_y = 0;
  for (int y = y0; y < y1; ++y) {
    const uint8_t* row = image.row(y);
    const double dy = y - map.center.y;
    for (int x = x0; x < x1; ++x) {
      const double dx = x - map.center.x;
      const double u = inverse[0] * dx + inverse[1] * dy;
      const double v = inverse[2] * dx + inverse[3] * dy;
      // How far inside the support, in pixels.
      const double inside_u = (reach_u - std::abs(u)) * pitch_u;
      const double inside_v = (reach_v - std::abs(v)) * pitch_v;
      const double weight = std::clamp(inside_u, 0.0, 1.0) * std::clamp(inside_v, 0.0, 1.0);
      const double inverse_white = inverse_level + slope.x * u + slope.y * v;
      const double signal = weight * (1 - row[x] * inverse_white);
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
    const double ratio = next.Determinant() / previous.Determinant();
    if (!(ratio > 0)) return {};  // beyond the lens model's range
    const double growth = std::log(ratio) / 2;
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

// A shape where it is expected in the image.
struct Target {
  Point2 tag;  // of its centre, units
  Shape shape;
  LocalMap map;  // its centre moved to where the centroid is expected
  Point2 bias;   // by this, pixels
  Shade white;   // of the gaps around it
};

Target MakeTarget(const ImageView& image, const TagMap& map, Point2 tag, const Shape& shape) {
  Target target{tag, shape, LocalMap(map, tag), {}, {}};
  target.bias = ShapeBias(map, tag, target.map, shape.second_moment);
  target.map.center.x += target.bias.x;
  target.map.center.y += target.bias.y;
  const Point2 ring{shape.half.x + kHalfGap, shape.half.y + kHalfGap};
  target.white = RingShade(image, target.map, ring);
  return target;
}

// Change of the white across the marker, grey levels per unit: least-squares plane through the
// targets' levels.
Point2 FitShading(const std::vector<Target>& targets) {
  const double n = static_cast<double>(targets.size());
  Point2 mean;
  for (const Target& t : targets) mean = {mean.x + t.tag.x / n, mean.y + t.tag.y / n};
  double xx = 0, xy = 0, yy = 0, xw = 0, yw = 0;
  for (const Target& t : targets) {
    const double x = t.tag.x - mean.x;
    const double y = t.tag.y - mean.y;
    xx += x * x;
    xy += x * y;
    yy += y * y;
    xw += x * t.white.level;
    yw += y * t.white.level;
  }
  const double det = xx * yy - xy * xy;
  return {(xw * yy - yw * xy) / det, (yw * xx - xw * xy) / det};
}

// The shading at one target: that of the whole marker, plus what its own gaps show beyond doubt.
// Around a small node, what lies beyond the gaps (nodes on one side, the frame on the other) blurs
// into them by more than the light changes.
Point2 LocalShading(const Target& target, Point2 whole) {
  const Jacobian2& j = target.map.j;
  const double unit = std::abs(target.map.Determinant()) /
                      std::max(std::hypot(j[3], j[1]), std::hypot(j[0], j[2]));  // pixels
  const double blur = kBlurShading * target.white.level / (unit * unit);
  const Point2 local{target.white.gradient.x - whole.x, target.white.gradient.y - whole.y};
  const double size = std::hypot(local.x, local.y);
  const double trust = size > blur ? 1 - blur / size : 0;
  return {whole.x + trust * local.x, whole.y + trust * local.y};
}

// Measured place of the target's centre, pixels; the expected one if there is too little contrast.
Point2 MeasureCenter(const ImageView& image, const Target& target, Point2 shading) {
  const LocalMap& map = target.map;
  const Point2 half = target.shape.half;
  const Point2 expected{map.center.x - target.bias.x, map.center.y - target.bias.y};
  const double unit = std::sqrt(std::abs(map.Determinant()));  // pixels
  const double delta = std::min(std::max(kMinDelta / unit, 2 * half.y / 10), kHalfGap);
  const double black = RingLevel(image, map, {half.x - kHalfGap, half.y - kHalfGap});
  const double contrast = 1 - black / target.white.level;
  const double full_signal = 4 * half.x * half.y * unit * unit * contrast;
  Point2 offset;
  if (!(contrast > 0) ||
      !Centroid(image, map, {half.x + delta, half.y + delta},
                {target.white.level, LocalShading(target, shading)}, kMinSignal * full_signal,
                &offset) ||
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
  std::vector<Target> targets;
  targets.reserve(static_cast<size_t>(family.node_count()));
  targets.push_back(MakeTarget(image, map, BaselineCenter(family), shapes.baseline));
  for (int i = 2; i < family.vertex_count(); ++i) {
    const Shape& shape = (bits >> i & 1) != 0 ? shapes.ring : shapes.solid;
    targets.push_back(MakeTarget(image, map, ModelVertex(family, i), shape));
  }
  const Point2 shading = FitShading(targets);
  std::array<Point2, kMaxVertices> ideal;
  bool inside_lens = true;
  measured->count = family.node_count();
  for (size_t k = 0; k < targets.size(); ++k) {
    measured->model[k] = targets[k].tag;
    measured->pixel[k] = MeasureCenter(image, targets[k], shading);
    inside_lens = inside_lens && PixelToIdeal(map.camera, measured->pixel[k], &ideal[k]);
  }
  Homography refined;
  if (inside_lens &&
      FitHomography(measured->model.data(), ideal.data(), measured->count, &refined)) {
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
