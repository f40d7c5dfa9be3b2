#include "host/vertices.h"

#include <algorithm>
#include <cmath>

#include "host/bias.h"
#include "host/centroid.h"
#include "host/local_map.h"
#include "host/model.h"
#include "host/shading.h"
#include "host/support.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

// A support that is off pulls the centroid by a sixteenth of that at 2 pixels a unit, by a
// hundredth at 6: nodes whose expected place moves by more than this when the map is refitted are
// measured again, once.
constexpr double kMoved = 0.03;       // pixels
constexpr double kMovedUnits = 0.02;  // units; the larger one counts
constexpr double kMinSignal = 0.2;    // of the signal of an unblurred shape
constexpr double kMaxOffset = 0.5;    // from the expected place, units

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

// What is measured of a marker: the nodes from vertex 2 on, then the baseline node as a whole.
struct Targets {
  int count;
  const Point2* tag;           // of the centres, units
  const NodeLevels* levels;    // of the gaps around them, and of their bodies
  Point2 moment[kMaxPoints];   // second moments
  float contrast[kMaxPoints];  // of the body
  Supports supports;
  double x[kMaxPoints], y[kMaxPoints];  // where the centroid was expected when it was measured
  Point2 bias[kMaxPoints];              // of the centroid, pixels
  Point2 lens_bias[kMaxPoints];         // the lens's part of it
  Point2 measured[kMaxPoints];          // centre: the centroid without its bias, pixels
};

void SetShapes(const Decoded& decoded, Targets* targets) {
  const NodeShapes shapes(decoded.node_area);
  const uint64_t bits = VertexBits(decoded.family, decoded.id);
  for (int i = 0; i < targets->count; ++i) {
    const Shape& shape = i == targets->count - 1      ? shapes.baseline
                         : (bits >> (i + 2) & 1) != 0 ? shapes.ring
                                                      : shapes.solid;
    targets->moment[i] = shape.second_moment;
    targets->supports.half_x[i] = static_cast<float>(shape.half.x);
    targets->supports.half_y[i] = static_cast<float>(shape.half.y);
    const NodeLevels& levels = targets->levels[i];
    targets->contrast[i] = 1 - levels.black / levels.white;
  }
}

void SetSupports(const LocalMaps& maps, Targets* targets) {
  Supports& s = targets->supports;
  for (int i = 0; i < targets->count; ++i) {
    s.xu[i] = static_cast<float>(maps.xu[i]);
    s.xv[i] = static_cast<float>(maps.xv[i]);
    s.yu[i] = static_cast<float>(maps.yu[i]);
    s.yv[i] = static_cast<float>(maps.yv[i]);
  }
}

void FindBias(const TagMap& map, const LocalMaps& maps, const Targets& targets, Point2* bias) {
  for (int i = 0; i < targets.count; ++i) {
    const Point2 p = PerspectiveBias(map.ideal, targets.tag[i]);
    const double u = p.x * targets.moment[i].x;
    const double v = p.y * targets.moment[i].y;
    bias[i] = {u * maps.xu[i] + v * maps.xv[i], u * maps.yu[i] + v * maps.yv[i]};
  }
  if (!map.HasLens()) return;
  for (int i = 0; i < targets.count; ++i) {
    bias[i].x += targets.lens_bias[i].x;
    bias[i].y += targets.lens_bias[i].y;
  }
}

// Sets a target's centre from the sums over its patch; takes the expected one if there is too
// little contrast.
void SetMeasured(const DarknessPatch& patch, const DarknessSums& sums, int i, Targets* targets) {
  const Supports& s = targets->supports;
  const double area = std::abs(s.xu[i] * s.yv[i] - s.xv[i] * s.yu[i]);  // pixels
  const double full_signal = 4 * s.half_x[i] * s.half_y[i] * area * targets->contrast[i];
  const auto sum = static_cast<double>(sums.sum);
  Point2& measured = targets->measured[i];
  measured = {targets->x[i] - targets->bias[i].x, targets->y[i] - targets->bias[i].y};
  // A weight and a darkness of 1 sum to one^2 black / 2^15.
  if (patch.width <= 0 ||
      !(sum > kMinSignal * full_signal * patch.one * patch.one * patch.black / 32768)) {
    return;
  }
  const double inverse_sum = 1 / sum;
  const double x = patch.x + static_cast<double>(sums.x) * inverse_sum - targets->x[i];
  const double y = patch.y + static_cast<double>(sums.y) * inverse_sum - targets->y[i];
  if (!(x * x + y * y < kMaxOffset * kMaxOffset * area)) return;
  measured.x += x;
  measured.y += y;
}

// Measures the centres of some targets. Each step is taken for all of them before the next: what
// one waits for, the others fill.
void MeasureTargets(const ImageView& image, Point2 shading, const bool* which, Targets* targets) {
  DarknessPatch patches[kMaxPoints];
  DarknessSums sums[kMaxPoints];
  const int count = targets->count;
  SetWhite(targets->levels, count, shading, &targets->supports);
  MakePatches(image, targets->supports, targets->x, targets->y, count, patches);
  for (int i = 0; i < count; ++i) {
    if (!which[i] || !(targets->contrast[i] > 0)) patches[i].width = 0;
  }
  SumDarkness(image, patches, count, sums);
  for (int i = 0; i < count; ++i) {
    if (which[i]) SetMeasured(patches[i], sums[i], i, targets);
  }
}

// The decoded map was fitted to centroids, so it is those that it takes the model to.
void MeasureAll(const ImageView& image, const TagMap& map, Point2 shading, Targets* targets) {
  const LocalMaps maps(map, targets->tag, targets->count);
  bool all[kMaxPoints];
  for (int i = 0; i < targets->count; ++i) {
    targets->x[i] = maps.x[i];
    targets->y[i] = maps.y[i];
    all[i] = true;
    if (map.HasLens()) {
      targets->lens_bias[i] = LensBias(map, targets->tag[i], targets->moment[i]);
    }
  }
  SetSupports(maps, targets);
  FindBias(map, maps, *targets, targets->bias);
  MeasureTargets(image, shading, all, targets);
}

// What a refitted map says better than the decoded one: the bias of all targets; and where those
// are expected that it moves, which are measured again.
void UpdateTargets(const ImageView& image, const TagMap& map, Point2 shading, Targets* targets) {
  const LocalMaps maps(map, targets->tag, targets->count);
  Point2 bias[kMaxPoints];
  FindBias(map, maps, *targets, bias);
  bool moved[kMaxPoints];
  bool any = false;
  for (int i = 0; i < targets->count; ++i) {
    const double x = maps.x[i] + bias[i].x;
    const double y = maps.y[i] + bias[i].y;
    const double dx = x - targets->x[i];
    const double dy = y - targets->y[i];
    const double area = std::abs(maps.Determinant(i));
    moved[i] = dx * dx + dy * dy > std::max(kMoved * kMoved, kMovedUnits * kMovedUnits * area);
    any |= moved[i];
    if (moved[i]) {
      targets->x[i] = x;
      targets->y[i] = y;
    } else {
      targets->measured[i].x += targets->bias[i].x - bias[i].x;
      targets->measured[i].y += targets->bias[i].y - bias[i].y;
    }
    targets->bias[i] = bias[i];
  }
  if (!any) return;
  SetSupports(maps, targets);
  MeasureTargets(image, shading, moved, targets);
}

// Takes what is measured near to where the map expects it to ideal pixels, with the lens linearised
// there: over a fraction of a pixel it is no curve.
void ToIdeal(const TagMap& map, const Targets& targets, Point2* ideal) {
  for (int i = 0; i < targets.count; ++i) {
    const LocalMap local(map, targets.tag[i]);
    Jacobian2 j;
    const Point2 p = map.ideal.Map(targets.tag[i], &j);
    const double scale = 1 / local.Determinant();
    const double dx = (targets.measured[i].x - local.center.x) * scale;
    const double dy = (targets.measured[i].y - local.center.y) * scale;
    const double u = local.j[3] * dx - local.j[1] * dy;
    const double v = local.j[0] * dy - local.j[2] * dx;
    ideal[i] = {p.x + j[0] * u + j[1] * v, p.y + j[2] * u + j[3] * v};
  }
}

// Refits the map to what is measured; false where it stays as it is.
bool RefitMap(const Targets& targets, TagMap* map) {
  Point2 ideal[kMaxPoints];
  if (map->HasLens()) ToIdeal(*map, targets, ideal);
  return FitHomography(targets.tag, map->HasLens() ? ideal : targets.measured, targets.count,
                       map->ideal, &map->ideal);
}

}  // namespace

void RefineVertices(const ImageView& image, Decoded* decoded, VertexList* vertices) {
  const int vertex_count = decoded->family.vertex_count();
  const Point2* model = ModelTable(decoded->family);
  Targets targets;
  targets.count = vertex_count - 1;
  targets.tag = model + 2;
  targets.levels = decoded->levels.data() + 2;
  SetShapes(*decoded, &targets);
  const Point2 shading = FitShading(targets.tag, targets.levels, targets.count);
  TagMap& map = decoded->map;
  MeasureAll(image, map, shading, &targets);
  if (RefitMap(targets, &map)) {
    UpdateTargets(image, map, shading, &targets);
    RefitMap(targets, &map);
  }

  vertices->resize(vertex_count);
  const Point2 baseline = targets.measured[vertex_count - 2];
  const Point2 expected = map.Pixel(model[vertex_count]);
  for (int i = 0; i < 2; ++i) {
    const Point2 p = map.Pixel(model[i]);
    (*vertices)[i] = {p.x + baseline.x - expected.x, p.y + baseline.y - expected.y};
  }
  std::copy(targets.measured, targets.measured + vertex_count - 2, vertices->begin() + 2);
}

}  // namespace topotag
