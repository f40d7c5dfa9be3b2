#include "host/bits.h"

#include <algorithm>
#include <cmath>

#include "host/local_map.h"
#include "host/model.h"
#include "host/shading.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

constexpr float kMinContrast = 6;  // of the gap to the body, grey levels
// Bodies must be alike: black in parts of the white around it. Markers at the limit of what is
// resolved come to 0.2 at 75 degrees; a quarter of a body covered by something bright is more.
constexpr float kMaxBodySpread = 0.22F;
constexpr double kMaxGapChange = 0.12;  // of a gap's white, per unit
constexpr int kMinUntouched = 4;        // nodes
// Holes and solid nodes must differ by this much of the contrast.
constexpr double kMinSpread = 0.2;
// Nodes of one kind, and relative variance of their resolution, that a slope is fitted to.
constexpr int kMinForSlope = 6;
constexpr double kMinVariance = 1e-3;
// The darkest of all nodes with holes, in parts of the baseline node's.
constexpr double kMinOpen = 0.15;
// A node this near to the middle between both kinds, in parts of their difference, is neither.
constexpr double kUndecided = 0.15;
// That of a hole beside the edge of a shadow, which the bit image shows, may be this low.
constexpr double kLeastInShadow = 0.3;

// Brightness as a line over the local resolution.
struct Line {
  double level, slope, from;
  double At(double resolution) const { return level + slope * (resolution - from); }
};

// The brightness of nodes of one kind over the local resolution, which perspective lets vary across
// the marker.
class Kind {
 public:
  void Add(double resolution, double hole) {
    ++count_;
    sum_x_ += resolution;
    sum_y_ += hole;
    sum_xx_ += resolution * resolution;
    sum_xy_ += resolution * hole;
  }
  int count() const { return count_; }
  Line Fit() const {
    const double inverse = 1.0 / count_;
    const double mean_x = sum_x_ * inverse;
    const double mean_y = sum_y_ * inverse;
    const double variance = sum_xx_ * inverse - mean_x * mean_x;
    const double covariance = sum_xy_ * inverse - mean_x * mean_y;
    const bool steep = count_ >= kMinForSlope && variance > kMinVariance * mean_x * mean_x;
    return {mean_y, steep ? covariance / variance : 0, mean_x};
  }

 private:
  int count_ = 0;
  double sum_x_ = 0, sum_y_ = 0, sum_xx_ = 0, sum_xy_ = 0;
};

// The nodes, as in VertexBits, beside which something dark lies in the gap: its white changes by
// more than the light does across the marker.
uint64_t FindTouched(Family family, const NodeLevels* levels) {
  const int count = family.bits();
  const Point2 light = FitShading(ModelTable(family) + 2, levels + 2, count + 1);
  uint64_t touched = 0;
  for (int i = 2; i < count + 3; ++i) {
    const double u = levels[i].white_u - light.x;
    const double v = levels[i].white_v - light.y;
    const double limit = kMaxGapChange * levels[i].white;
    if (u * u + v * v > limit * limit) touched |= i == count + 2 ? 3 : uint64_t{1} << i;
  }
  return touched;
}

}  // namespace

bool ConfirmBits(const ImageView& image, Decoded* decoded) {
  const Family family = decoded->family;
  const int count = family.vertex_count();
  const uint64_t read = VertexBits(family, decoded->id) | 3;  // p1 and p2 are holes
  const LocalMaps maps(decoded->map, ModelTable(family), count + 1);
  NodeLevels* levels = decoded->levels.data();
  // Brightness of the centre over that of the body around it, in parts of the contrast.
  float hole[kMaxVertices];
  if (!MeasureLevels(image, family, maps, levels, hole)) return false;
  float sum = 0;
  float least = INFINITY;
  float darkest_body = INFINITY;
  float brightest_body = 0;
  for (int i = 2; i < count; ++i) {
    const float contrast = levels[i].white - levels[i].black;
    sum += contrast;
    least = std::min(least, contrast);
    const float body = levels[i].black / levels[i].white;
    darkest_body = std::min(darkest_body, body);
    brightest_body = std::max(brightest_body, body);
  }
  if (!(least > kMinContrast && brightest_body - darkest_body < kMaxBodySpread)) return false;
  const uint64_t touched = FindTouched(family, levels);
  const bool are_many = family.bits() - __builtin_popcountll(touched) < kMinUntouched;
  decoded->unmeasured = are_many ? 0 : touched;
  const float mean_contrast = sum / static_cast<float>(count - 2);
  float resolution[kMaxVertices];
  Kind kinds[2];
  float darkest = INFINITY;
  for (int i = 0; i < count; ++i) {
    // The gap around p1 or p2 alone is not that of a node.
    const float contrast = i < 2 ? mean_contrast : levels[i].white - levels[i].black;
    hole[i] = (hole[i] - levels[i].black) / contrast;
    resolution[i] = std::sqrt(static_cast<float>(std::abs(maps.Determinant(i))));
    kinds[read >> i & 1].Add(resolution[i], hole[i]);
    darkest = std::min(darkest, hole[i]);
  }
  decoded->quality.contrast = mean_contrast;
  if (kinds[0].count() == 0) {
    const double open = kinds[1].Fit().At(resolution[0]);
    const double least = kMinOpen * open;
    decoded->quality.sharpness = open;
    decoded->quality.decision = std::clamp((darkest - least) / (open - least), 0.0, 1.0);
    return darkest > least;
  }

  const Line solids = kinds[0].Fit();
  const Line rings = kinds[1].Fit();
  uint64_t bits = 0;
  bool clear = true;
  double decision = 1;
  double spreads = 0;
  for (int i = 2; i < count; ++i) {
    const double solid = solids.At(resolution[i]);
    const double spread = rings.At(resolution[i]) - solid;
    const double above = hole[i] - solid;
    spreads += spread;
    // In the shadow a hole is darker than most of a gap that lies in the light; what is solid is
    // not brighter than its body anywhere. There the bit image tells, and must not be contradicted.
    if ((touched >> i & 1) != 0) {
      const bool is_ring = (read >> i & 1) != 0;
      clear &= spread > kMinSpread &&
               (is_ring ? above > kLeastInShadow * spread : above < (0.5 - kUndecided) * spread);
      bits |= uint64_t{is_ring} << i;
      decision = std::min(decision, (is_ring ? 2 : -2) * (above / spread - 0.5));
      continue;
    }
    clear &= spread > kMinSpread && std::abs(above - 0.5 * spread) >= kUndecided * spread;
    bits |= static_cast<uint64_t>(above > 0.5 * spread) << i;
    decision = std::min(decision, 2 * std::abs(above / spread - 0.5));
  }
  if (!clear) return false;
  decoded->quality.sharpness = spreads / (count - 2);
  decoded->quality.decision = std::max(decision, 0.0);
  decoded->id = IdFromVertexBits(family, bits);
  return true;
}

}  // namespace topotag
