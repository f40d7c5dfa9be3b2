#include "host/bits.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/model.h"
#include "host/sample.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

constexpr Point2 kBodyRing{1, 1};   // half sides of the square in the middle of the body, units
constexpr Point2 kGapRing{2, 2};    // the same of the gap
constexpr double kMinContrast = 6;  // of the gap to the body, grey levels
// Holes and solid nodes must differ by this much of the contrast.
constexpr double kMinSpread = 0.2;
// Nodes of one kind, and relative variance of their resolution, that a slope is fitted to.
constexpr int kMinForSlope = 6;
constexpr double kMinVariance = 1e-3;
// The darkest of all nodes with holes, in parts of the baseline node's.
constexpr double kMinOpen = 0.15;
// A node this near to the middle between both kinds, in parts of their difference, is neither.
constexpr double kUndecided = 0.15;

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

}  // namespace

bool ConfirmBits(const ImageView& image, Decoded* decoded) {
  const Family family = decoded->family;
  const int count = family.vertex_count();
  const uint64_t read = VertexBits(family, decoded->id) | 3;  // p1 and p2 are holes
  // Brightness of the centre over that of the body around it, in parts of the contrast.
  std::array<double, kMaxVertices> hole;
  std::array<double, kMaxVertices> resolution;
  Kind kinds[2];
  double mean_contrast = 0;
  double darkest = INFINITY;
  const Point2* model = ModelTable(family);
  for (int i = count - 1; i >= 0; --i) {
    const auto k = static_cast<size_t>(i);
    const LocalMap map(decoded->map, model[i]);
    const double unit_area = std::abs(map.Determinant());  // pixels
    NodeLevels& levels = decoded->levels[k];
    levels = MeasureLevels(image, map, kGapRing, kBodyRing);
    // The gap around p1 or p2 alone is not that of a node.
    const double contrast = i < 2 ? mean_contrast : levels.white - levels.black;
    if (!(contrast > kMinContrast)) return false;
    if (i >= 2) mean_contrast += contrast / (count - 2);
    resolution[k] = std::sqrt(unit_area);
    hole[k] = (Bilinear(image, map.center) - levels.black) / contrast;
    kinds[read >> i & 1].Add(resolution[k], hole[k]);
    darkest = std::min(darkest, hole[k]);
  }
  if (kinds[0].count() == 0) return darkest > kMinOpen * kinds[1].Fit().At(resolution[0]);

  const Line solids = kinds[0].Fit();
  const Line rings = kinds[1].Fit();
  uint64_t bits = 0;
  for (int i = 2; i < count; ++i) {
    const auto k = static_cast<size_t>(i);
    const double solid = solids.At(resolution[k]);
    const double spread = rings.At(resolution[k]) - solid;
    if (!(spread > kMinSpread)) return false;
    const double from_middle = (hole[k] - solid) / spread - 0.5;
    if (std::abs(from_middle) < kUndecided) return false;
    bits |= static_cast<uint64_t>(from_middle > 0) << i;
  }
  decoded->id = IdFromVertexBits(family, bits);
  return true;
}

}  // namespace topotag
