#include "host/vertices.h"

#include <algorithm>
#include <cmath>

#include "host/bias.h"
#include "host/centroid.h"
#include "host/leak.h"
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

// Where nodes lie between circles, 0, and squares, 1, as their area says; hexagons fit in between.
double Squareness(double node_area) {
  constexpr double kCircle = 7.07;
  constexpr double kSquare = 9;
  return std::clamp((node_area - kCircle) / (kSquare - kCircle), 0.0, 1.0);
}

// Second moments of a marker's nodes: mean of u^2 and of v^2 over the area, square units.
struct NodeMoments {
  explicit NodeMoments(double squareness) {
    const auto mix = [&](double circle, double square) {
      return circle + squareness * (square - circle);
    };
    solid = {mix(0.5625, 0.75), mix(0.5625, 0.75)};
    ring = {mix(0.625, 0.8333), mix(0.625, 0.8333)};
    baseline = {mix(1.845, 2.238), mix(0.676, 0.8525)};
  }

  Point2 solid, ring, baseline;
};

// What is measured of a marker: nodes from vertex 2 on, then, where baseline is set, the baseline
// node as a whole.
struct Targets {
  int count;
  bool baseline;
  const int* vertex;           // of each
  const Point2* tag;           // of the centres, units
  const NodeLevels* levels;    // of the gaps around them, and of their bodies
  Point2 moment[kMaxPoints];   // second moments, square units
  float contrast[kMaxPoints];  // of the body
  Point2 shading;              // grey levels per unit
  Supports supports;
  double x[kMaxPoints], y[kMaxPoints];  // where the centroid was expected when it was measured
  Point2 bias[kMaxPoints];              // of the centroid, pixels
  Point2 lens_bias[kMaxPoints];         // the lens's part of it
  bool leaky;                           // whether `leak` counts
  Point2 leak[kMaxPoints];              // into the supports (host/leak.h)
  Point2 measured[kMaxPoints];          // centre: the centroid without its bias, pixels
  Point2 ideal[kMaxPoints];             // the same without the lens, where there is one
};

void SetHalfSides(Family family, Targets* targets) {
  Supports& s = targets->supports;
  for (int i = 0; i < targets->count; ++i) {
    s.half_x[i] = targets->vertex[i] == family.vertex_count() ? 2.5F : 1.5F;
    s.half_y[i] = 1.5F;
  }
}

void SetMoments(const Decoded& decoded, double squareness, Targets* targets) {
  const NodeMoments moments(squareness);
  const uint64_t bits = VertexBits(decoded.family, decoded.id);
  for (int i = 0; i < targets->count; ++i) {
    const int vertex = targets->vertex[i];
    targets->moment[i] = vertex == decoded.family.vertex_count() ? moments.baseline
                         : (bits >> vertex & 1) != 0             ? moments.ring
                                                                 : moments.solid;
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
  if (patch.width <= 0) return;
  // The sum of a pixel whose weight and darkness are 1.
  const double full = patch.one * patch.one * patch.black / 32768.0;
  if (!(sum > kMinSignal * full_signal * full)) return;
  const double inverse_sum = 1 / sum;
  double x = patch.x + static_cast<double>(sums.x) * inverse_sum - targets->x[i];
  double y = patch.y + static_cast<double>(sums.y) * inverse_sum - targets->y[i];
  if (targets->leaky) {
    const double share = area * full * inverse_sum;
    const Point2 leak = targets->leak[i];
    x -= share * (s.xu[i] * leak.x + s.xv[i] * leak.y);
    y -= share * (s.yu[i] * leak.x + s.yv[i] * leak.y);
  }
  if (!(x * x + y * y < kMaxOffset * kMaxOffset * area)) return;
  measured.x += x;
  measured.y += y;
}

// Measures the centres of some targets. Each step is taken for all of them before the next: what
// one waits for, the others fill.
void MeasureTargets(const ImageView& image, const bool* which, Targets* targets) {
  DarknessPatch patches[kMaxPoints];
  DarknessSums sums[kMaxPoints];
  const int count = targets->count;
  SetWhite(targets->levels, count, targets->shading, &targets->supports);
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
void MeasureAll(const ImageView& image, const Decoded& decoded, Targets* targets) {
  const TagMap& map = decoded.map;
  const LocalMaps maps(map, targets->tag, targets->count);
  bool all[kMaxPoints];
  for (int i = 0; i < targets->count; ++i) {
    targets->x[i] = maps.x[i];
    targets->y[i] = maps.y[i];
    all[i] = true;
    const NodeLevels& levels = targets->levels[i];
    targets->contrast[i] = 1 - levels.black / levels.white;
  }
  targets->shading = FitShading(targets->tag, maps, targets->levels, targets->count);
  SetSupports(maps, targets);
  SetHalfSides(decoded.family, targets);
  double squareness = Squareness(decoded.node_area);
  targets->leaky = FindLeaks(image, decoded, maps, targets->supports, targets->vertex,
                             targets->count, &squareness, targets->leak);
  SetMoments(decoded, squareness, targets);
  for (int i = 0; i < targets->count && map.HasLens(); ++i) {
    targets->lens_bias[i] = LensBias(map, targets->tag[i], targets->moment[i]);
  }
  FindBias(map, maps, *targets, targets->bias);
  MeasureTargets(image, all, targets);
}

// What a refitted map says better than the decoded one: the bias of all targets; and where those
// are expected that it moves, which are measured again.
void UpdateTargets(const ImageView& image, const TagMap& map, Targets* targets) {
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
  MeasureTargets(image, moved, targets);
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
bool RefitMap(Targets* targets, TagMap* map) {
  if (map->HasLens()) ToIdeal(*map, *targets, targets->ideal);
  return FitHomography(targets->tag, map->HasLens() ? targets->ideal : targets->measured,
                       targets->count, map->ideal, &map->ideal);
}

// Root mean square distance of what is measured from the map that was fitted to it.
double FitError(const Targets& targets, const TagMap& map) {
  const Point2* measured = map.HasLens() ? targets.ideal : targets.measured;
  double sum = 0;
  for (int i = 0; i < targets.count; ++i) {
    const Point2 p = map.ideal.Map(targets.tag[i]);
    const double dx = measured[i].x - p.x, dy = measured[i].y - p.y;
    sum += dx * dx + dy * dy;
  }
  return targets.count > 0 ? std::sqrt(sum / targets.count) : 0;
}

// The points that are measured, in arrays: all of them from vertex 2 on are, unless something is in
// the way.
struct Measured {
  explicit Measured(const Decoded& decoded) {
    const int vertices = decoded.family.vertex_count();
    const Point2* model = ModelTable(decoded.family);
    const uint64_t left_out = decoded.unmeasured;
    for (int i = 2; i <= vertices; ++i) {
      const bool is_baseline = i == vertices;
      if (is_baseline ? (left_out & 3) != 0 : (left_out >> i & 1) != 0) continue;
      vertex[count] = i;
      tag[count] = model[i];
      levels[count++] = decoded.levels[static_cast<size_t>(i)];
      baseline = is_baseline;
    }
  }

  int count = 0;
  bool baseline = false;
  int vertex[kMaxPoints];
  Point2 tag[kMaxPoints];
  NodeLevels levels[kMaxPoints];
};

}  // namespace

void RefineVertices(const ImageView& image, Decoded* decoded, VertexList* vertices) {
  const int vertex_count = decoded->family.vertex_count();
  const Point2* model = ModelTable(decoded->family);
  const Measured points(*decoded);
  Targets targets;
  targets.count = points.count;
  targets.baseline = points.baseline;
  targets.vertex = points.vertex;
  targets.tag = points.tag;
  targets.levels = points.levels;
  TagMap& map = decoded->map;
  MeasureAll(image, *decoded, &targets);
  if (RefitMap(&targets, &map)) {
    UpdateTargets(image, map, &targets);
    RefitMap(&targets, &map);
  }
  decoded->quality.rms_px = FitError(targets, map);

  vertices->resize(vertex_count);
  Point2 shift;  // of the baseline node from where it is expected
  if (targets.baseline) {
    const Point2 expected = map.Pixel(model[vertex_count]);
    const Point2 measured = targets.measured[targets.count - 1];
    shift = {measured.x - expected.x, measured.y - expected.y};
  }
  for (int i = 0; i < 2; ++i) {
    const Point2 p = map.Pixel(model[i]);
    (*vertices)[i] = {p.x + shift.x, p.y + shift.y};
  }
  if (decoded->unmeasured != 0) {
    for (int i = 2; i < vertex_count; ++i) (*vertices)[i] = map.Pixel(model[i]);
  }
  for (int i = 0; i < targets.count - targets.baseline; ++i) {
    (*vertices)[targets.vertex[i]] = targets.measured[i];
  }
}

}  // namespace topotag
