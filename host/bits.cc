#include "host/bits.h"

#include <algorithm>
#include <array>
#include <cmath>

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

// The brightness of nodes of one kind as a line over the local resolution, which perspective lets
// vary across the marker.
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
  double At(double resolution) const {
    const double mean_x = sum_x_ / count_;
    const double variance = sum_xx_ / count_ - mean_x * mean_x;
    const double covariance = sum_xy_ / count_ - mean_x * sum_y_ / count_;
    const bool steep = count_ >= kMinForSlope && variance > kMinVariance * mean_x * mean_x;
    const double slope = steep ? covariance / variance : 0;
    return sum_y_ / count_ + slope * (resolution - mean_x);
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
  std::array<double, kMaxVertices> hole{};
  std::array<double, kMaxVertices> resolution{};
  Kind kinds[2];
  double mean_contrast = 0;
  double darkest = INFINITY;
  for (int i = count - 1; i >= 0; --i) {
    const auto k = static_cast<size_t>(i);
    const LocalMap map(decoded->map, ModelVertex(family, i));
    const double body = RingLevel(image, map, kBodyRing);
    // The gap around p1 or p2 alone is not that of a node.
    const double contrast = i < 2 ? mean_contrast : RingLevel(image, map, kGapRing) - body;
    if (!(contrast > kMinContrast)) return false;
    if (i >= 2) mean_contrast += contrast / (count - 2);
    resolution[k] = std::sqrt(std::abs(map.Determinant()));
    hole[k] = (Bilinear(image, map.center) - body) / contrast;
    kinds[read >> i & 1].Add(resolution[k], hole[k]);
    darkest = std::min(darkest, hole[k]);
  }
  if (kinds[0].count() == 0) return darkest > kMinOpen * kinds[1].At(resolution[0]);

  uint64_t bits = 0;
  for (int i = 2; i < count; ++i) {
    const auto k = static_cast<size_t>(i);
    const double solid = kinds[0].At(resolution[k]);
    const double spread = kinds[1].At(resolution[k]) - solid;
    if (!(spread > kMinSpread)) return false;
    const double from_middle = (hole[k] - solid) / spread - 0.5;
    if (std::abs(from_middle) < kUndecided) return false;
    bits |= static_cast<uint64_t>(from_middle > 0) << i;
  }
  decoded->id = IdFromVertexBits(family, bits);
  return true;
}

}  // namespace topotag
