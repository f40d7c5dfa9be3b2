#include "host/vertices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "host/centroid.h"
#include "host/model.h"
#include "host/sample.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

// A support that is off pulls the centroid by a twentieth of that: nodes whose expected place moves
// by more than this when the map is refitted are measured again, once.
constexpr double kMoved = 0.03;  // pixels
constexpr double kMinDelta = 2;  // pixels
// Largest gradient of the gaps' white by blur alone, per unit, at 1 pixel a unit; it falls with the
// square of the resolution.
constexpr double kBlurShading = 0.5;
constexpr double kHalfGap = 0.5;    // units
constexpr double kMinSignal = 0.2;  // of the signal of an unblurred shape
constexpr double kMaxOffset = 0.5;  // from the expected place, units

// White that varies linearly: grey level at a point, and its change per unit of u and v.
struct Shade {
  double level;
  Point2 gradient;
};

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

// Fixed point: 16 bits, of which so many are used.
constexpr double kMaxFixed = 32000;
// Pixels beside a patch that are computed too, without weight.
constexpr int kOverhang = 32;
// One pixel of distance, and a darkness of 1, at most.
constexpr int kOnePixel = 1 << 7;
constexpr int kOneDarkness = 1 << 14;

// The largest power of 2, at most `limit`, times which `bound` fits; 0 if there is none.
int FixedOne(double bound, int limit) {
  int one = limit;
  while (one > 0 && !(bound * one < kMaxFixed)) one /= 2;
  return one;
}

// A function of the pixel with the value `level` at `center` and the gradient `slope`, times `one`.
LinearValue FixedLinear(Point2 center, double level, Point2 slope, double one) {
  const double scale = one * 256;
  return {static_cast<int32_t>((level - slope.x * center.x - slope.y * center.y) * scale) + 128,
          static_cast<int32_t>(slope.x * scale), static_cast<int32_t>(slope.y * scale)};
}

// The patch for the weighted centroid of the darkness 1 - grey / white over the support: relative
// to the shaded white, so that uneven light does not move it. The support is a parallelogram of
// half sides `half`, its edge smoothed over one pixel.
// @return false where there is nothing to measure.
bool MakePatch(const ImageView& image, const LocalMap& map, Point2 half, const Shade& white,
               DarknessPatch* result) {
  const Jacobian2& j = map.j;
  const double det = map.Determinant();
  const double inverse_det = 1 / det;
  // Pixels across which u grows by one unit are |det| / length_u.
  const double length_u = std::sqrt(j[3] * j[3] + j[1] * j[1]);
  const double length_v = std::sqrt(j[0] * j[0] + j[2] * j[2]);
  const double inverse_u = 1 / length_u;
  const double inverse_v = 1 / length_v;
  const double reach_u = half.x + 0.5 * length_u * std::abs(inverse_det);
  const double reach_v = half.y + 0.5 * length_v * std::abs(inverse_det);
  const Point2 extent{reach_u * std::abs(j[0]) + reach_v * std::abs(j[1]),
                      reach_u * std::abs(j[2]) + reach_v * std::abs(j[3])};
  if (!(map.center.x - extent.x > -kMaxImageSide && map.center.x + extent.x < 2 * kMaxImageSide &&
        map.center.y - extent.y > -kMaxImageSide && map.center.y + extent.y < 2 * kMaxImageSide)) {
    return false;
  }
  DarknessPatch& patch = *result;
  patch.x = std::max(static_cast<int>(map.center.x - extent.x) + 1, 0);
  patch.y = std::max(static_cast<int>(map.center.y - extent.y) + 1, 0);
  patch.width = std::min(static_cast<int>(map.center.x + extent.x) + 1, image.width) - patch.x;
  patch.height = std::min(static_cast<int>(map.center.y + extent.y) + 1, image.height) - patch.y;
  if (patch.width <= 0 || patch.height <= 0) return false;
  const Point2 center{map.center.x - patch.x, map.center.y - patch.y};

  const Point2 slope_u{j[3] * inverse_u, -j[1] * inverse_u};
  const Point2 slope_v{-j[2] * inverse_v, j[0] * inverse_v};
  const double wide = std::max(std::abs(center.x), std::abs(patch.width - center.x)) + kOverhang;
  const double high = std::max(std::abs(center.y), std::abs(patch.height - center.y));
  const int one = FixedOne(wide + high + 1, kOnePixel);  // the slopes have length 1
  // 1 / white, to first order in the shading.
  const double inverse_level = 1 / white.level;
  const double per_unit = -inverse_level * inverse_level * inverse_det;
  const Point2 slope_white{(white.gradient.x * j[3] - white.gradient.y * j[2]) * per_unit,
                           (white.gradient.y * j[0] - white.gradient.x * j[1]) * per_unit};
  const double largest =
      inverse_level + std::abs(slope_white.x) * extent.x + std::abs(slope_white.y) * extent.y;
  const int black = FixedOne(256 * largest, kOneDarkness);
  if (one == 0 || black == 0) return false;
  patch.one = static_cast<int16_t>(one);
  patch.black = static_cast<int16_t>(black);
  patch.u = FixedLinear(center, 0, slope_u, one);
  patch.v = FixedLinear(center, 0, slope_v, one);
  const double scale = std::abs(det) * one;
  patch.reach_u = static_cast<int16_t>(std::min(reach_u * inverse_u * scale, kMaxFixed));
  patch.reach_v = static_cast<int16_t>(std::min(reach_v * inverse_v * scale, kMaxFixed));
  patch.inverse_white = FixedLinear(center, inverse_level, slope_white, 256.0 * black);

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
    // Half the logarithm of the ratio, which is near 1, without a function whose last digit
    // depends on the CPU.
    const double growth = (ratio - 1) / (ratio + 1);
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
  const Shape* shape;
  LocalMap map;     // its centre is where the centroid was expected when it was measured
  Point2 bias;      // of the centroid, pixels
  Shade white;      // of the gaps around it
  double black;     // of its body
  Point2 measured;  // centre: the centroid without its bias, pixels
};

// What is measured of a marker: the baseline node as a whole, then the nodes from vertex 2 on.
struct Targets {
  int count = 0;
  std::array<Target, kMaxVertices> at;
};

void AddTarget(const TagMap& map, Point2 tag, const Shape& shape, Targets* targets) {
  Target& target = targets->at[static_cast<size_t>(targets->count++)];
  target.tag = tag;
  target.shape = &shape;
  target.map = LocalMap(map, tag);
  target.bias = ShapeBias(map, tag, target.map, shape.second_moment);
}

void SetLevels(const NodeLevels& levels, Target* target) {
  target->white = {levels.white, {levels.white_u, levels.white_v}};
  target->black = levels.black;
}

// The decoded map was fitted to centroids, so it is those that it takes the model to.
void MakeTargets(const ImageView& image, const Decoded& decoded, const NodeShapes& shapes,
                 Targets* targets) {
  const Family family = decoded.family;
  const Point2* model = ModelTable(family);
  AddTarget(decoded.map, {model[0].x + 1, model[0].y}, shapes.baseline, targets);
  Target& baseline = targets->at[0];
  const Point2 half = shapes.baseline.half;
  SetLevels(MeasureLevels(image, baseline.map, {half.x + kHalfGap, half.y + kHalfGap},
                          {half.x - kHalfGap, half.y - kHalfGap}),
            &baseline);
  const uint64_t bits = VertexBits(family, decoded.id);
  for (int i = 2; i < family.vertex_count(); ++i) {
    AddTarget(decoded.map, model[i], (bits >> i & 1) != 0 ? shapes.ring : shapes.solid, targets);
    SetLevels(decoded.levels[static_cast<size_t>(i)], &targets->at[static_cast<size_t>(i - 1)]);
  }
}

// Change of the white across the marker, grey levels per unit: least-squares plane through the
// targets' levels.
Point2 FitShading(const Targets& targets) {
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0, w = 0, xw = 0, yw = 0;
  for (int i = 0; i < targets.count; ++i) {
    const Target& t = targets.at[static_cast<size_t>(i)];
    x += t.tag.x;
    y += t.tag.y;
    w += t.white.level;
    xx += t.tag.x * t.tag.x;
    xy += t.tag.x * t.tag.y;
    yy += t.tag.y * t.tag.y;
    xw += t.tag.x * t.white.level;
    yw += t.tag.y * t.white.level;
  }
  const double inverse = 1.0 / targets.count;
  xx -= x * x * inverse;
  xy -= x * y * inverse;
  yy -= y * y * inverse;
  xw -= x * w * inverse;
  yw -= y * w * inverse;
  const double det = xx * yy - xy * xy;
  return {(xw * yy - yw * xy) / det, (yw * xx - xw * xy) / det};
}

// The shading at one target: that of the whole marker, plus what its own gaps show beyond doubt.
// Around a small node, what lies beyond the gaps (nodes on one side, the frame on the other) blurs
// into them by more than the light changes.
Point2 LocalShading(const Target& target, Point2 whole) {
  const Jacobian2& j = target.map.j;
  const double det = target.map.Determinant();
  // Squared pixels of the shorter height of a square unit.
  const double unit = det * det / std::max(j[3] * j[3] + j[1] * j[1], j[0] * j[0] + j[2] * j[2]);
  const double blur = kBlurShading * target.white.level / unit;
  const Point2 local{target.white.gradient.x - whole.x, target.white.gradient.y - whole.y};
  const double square = local.x * local.x + local.y * local.y;
  if (!(square > blur * blur)) return whole;
  const double trust = 1 - blur / std::sqrt(square);
  return {whole.x + trust * local.x, whole.y + trust * local.y};
}

// Darkness of the target's body.
double Contrast(const Target& target) { return 1 - target.black / target.white.level; }

// Half sides of the target's support, units.
Point2 SupportHalf(const Target& target) {
  const Point2 half = target.shape->half;
  const double unit = std::sqrt(std::abs(target.map.Determinant()));  // pixels
  const double delta = std::min(std::max(kMinDelta / unit, 2 * half.y / 10), kHalfGap);
  return {half.x + delta, half.y + delta};
}

// Sets the target's centre from the sums over its patch; takes the expected one if there is too
// little contrast.
void SetMeasured(const DarknessPatch& patch, const DarknessSums& sums, Target* target) {
  const LocalMap& map = target->map;
  const Point2 half = target->shape->half;
  const double unit_area = std::abs(map.Determinant());  // pixels
  const double full_signal = 4 * half.x * half.y * unit_area * Contrast(*target);
  const double sum = static_cast<double>(sums.sum);
  target->measured = {map.center.x - target->bias.x, map.center.y - target->bias.y};
  // A weight and a darkness of 1 sum to one^2 black / 2^15.
  if (!(sum > kMinSignal * full_signal * patch.one * patch.one * patch.black / 32768)) return;
  const double inverse_sum = 1 / sum;
  const double x = patch.x + static_cast<double>(sums.x) * inverse_sum - map.center.x;
  const double y = patch.y + static_cast<double>(sums.y) * inverse_sum - map.center.y;
  if (!(x * x + y * y < kMaxOffset * kMaxOffset * unit_area)) return;
  target->measured.x += x;
  target->measured.y += y;
}

// Measures the centres of some targets. Each step is taken for all of them before the next: what
// one waits for, the others fill.
// @param which  their indices
void MeasureTargets(const ImageView& image, Point2 shading,
                    const std::array<int, kMaxVertices>& which, int count, Targets* targets) {
  std::array<DarknessPatch, kMaxVertices> patches;
  std::array<DarknessSums, kMaxVertices> sums;
  const auto target = [&](size_t k) -> Target& {
    return targets->at[static_cast<size_t>(which[k])];
  };
  for (size_t k = 0; k < static_cast<size_t>(count); ++k) {
    const Target& t = target(k);
    const Shade white{t.white.level, LocalShading(t, shading)};
    if (!(Contrast(t) > 0) || !MakePatch(image, t.map, SupportHalf(t), white, &patches[k])) {
      patches[k] = {};
    }
  }
  SumDarkness(image, patches.data(), count, sums.data());
  for (size_t k = 0; k < static_cast<size_t>(count); ++k) {
    SetMeasured(patches[k], sums[k], &target(k));
  }
}

// Refits the map to what is measured; false where it stays as it is.
bool RefitMap(const Targets& targets, TagMap* map) {
  std::array<Point2, kMaxVertices> tag;
  std::array<Point2, kMaxVertices> ideal;
  for (int i = 0; i < targets.count; ++i) {
    const auto k = static_cast<size_t>(i);
    tag[k] = targets.at[k].tag;
    if (!PixelToIdeal(map->camera, targets.at[k].measured, &ideal[k])) return false;
  }
  Homography refined;
  if (!FitHomography(tag.data(), ideal.data(), targets.count, map->ideal, &refined)) return false;
  map->ideal = refined;
  return true;
}

// What the refitted map says better than the decoded one: the bias of all targets; and where those
// are expected that it moves, which are measured again.
void UpdateTargets(const ImageView& image, const TagMap& map, Point2 shading, Targets* targets) {
  std::array<int, kMaxVertices> moved;
  int count = 0;
  for (int i = 0; i < targets->count; ++i) {
    Target& target = targets->at[static_cast<size_t>(i)];
    const LocalMap local(map, target.tag);
    const Point2 bias = ShapeBias(map, target.tag, local, target.shape->second_moment);
    const Point2 expected{local.center.x + bias.x, local.center.y + bias.y};
    const double dx = expected.x - target.map.center.x;
    const double dy = expected.y - target.map.center.y;
    if (dx * dx + dy * dy > kMoved * kMoved) {
      target.map = local;
      target.map.center = expected;
      target.bias = bias;
      moved[static_cast<size_t>(count++)] = i;
    } else {
      target.measured.x += target.bias.x - bias.x;
      target.measured.y += target.bias.y - bias.y;
    }
  }
  if (count > 0) MeasureTargets(image, shading, moved, count, targets);
}

}  // namespace

void RefineVertices(const ImageView& image, Decoded* decoded, VertexList* vertices) {
  const NodeShapes shapes(decoded->node_area);
  Targets targets;
  MakeTargets(image, *decoded, shapes, &targets);
  const Point2 shading = FitShading(targets);
  std::array<int, kMaxVertices> all;
  std::iota(all.begin(), all.begin() + targets.count, 0);
  MeasureTargets(image, shading, all, targets.count, &targets);
  TagMap& map = decoded->map;
  if (RefitMap(targets, &map)) {
    UpdateTargets(image, map, shading, &targets);
    RefitMap(targets, &map);
  }

  vertices->resize(decoded->family.vertex_count());
  const Target& baseline = targets.at[0];
  const Point2 expected = map.Pixel(baseline.tag);
  const Point2* model = ModelTable(decoded->family);
  for (int i = 0; i < 2; ++i) {
    const Point2 p = map.Pixel(model[i]);
    (*vertices)[i] = {p.x + baseline.measured.x - expected.x,
                      p.y + baseline.measured.y - expected.y};
  }
  for (int i = 1; i < targets.count; ++i) {
    (*vertices)[i + 1] = targets.at[static_cast<size_t>(i)].measured;
  }
}

}  // namespace topotag
