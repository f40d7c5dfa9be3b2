#include <algorithm>
#include <cmath>

#include "host/cholesky.h"
#include "host/far_fit.h"

namespace topotag {
namespace {

// Of the modulation within the marker: on one side along each axis, on any side.
constexpr double kGoesOn = 0.35;
constexpr double kSurelyGoesOn = 0.8;

}  // namespace

// Of the noise, from the residual; rounding alone brings a twelfth.
double FarFit::Variance() const {
  return std::max(stats_.residual / std::max(stats_.count - kDense, 1), 1.0 / 12);
}

// What each bit's flip would add to the residual, all else unchanged.
bool FarFit::TestFlips(FarReading* reading, bool* flipped) {
  *flipped = false;
  const double depth = -levels_.node;
  const double variance = Variance();
  reading->margin = INFINITY;
  reading->min_step = INFINITY;
  for (int h = 2; h < family_.vertex_count(); ++h) {
    const double sign = (bits_ >> h & 1) != 0 ? -1 : 1;
    const double ideal = depth * depth * flip_square_[h];
    const double rise = ideal - 2 * sign * depth * flip_product_[h];
    if (rise < 0) {
      bits_ ^= uint64_t{1} << h;
      hole_[h] = (bits_ >> h & 1) != 0 ? static_cast<float>(depth) : 0;
      *flipped = true;
    }
    reading->margin = std::min(reading->margin, rise / (2 * variance));
    reading->min_step = std::min(reading->min_step, rise / ideal);
  }
  return true;
}

// Makes the step with the shape that it leaves the smallest residual with, as it foretells itself.
bool FarFit::ChooseShape() {
  double best = INFINITY;
  FarModel::Shape chosen = shape_;
  double steps[kDense];
  for (const FarModel::Shape& shape : {FarModel::kSquare, FarModel::kHexagon, FarModel::kCircle}) {
    shape_ = shape;
    if (!SetModel(kCoarse)) continue;
    Accumulate(false);
    double slope[kDense];
    std::copy(gradient_, gradient_ + kDense, slope);
    if (stats_.correlation < kEarlyCorrelation || !Solve(false)) continue;
    double residual = stats_.residual;
    for (int i = 0; i < kDense; ++i) residual -= slope[i] * gradient_[i];
    if (residual >= best) continue;
    best = residual;
    chosen = shape;
    std::copy(gradient_, gradient_ + kDense, steps);
  }
  if (!(best < INFINITY)) return false;
  shape_ = chosen;
  std::copy(steps, steps + kDense, gradient_);
  Move(false);
  return true;
}

// Whether gaps go on beyond the white area: then it is a part of a larger grid, which it exceeds on
// one side at least along each axis. Compared is the modulation with the grid's period, in a strip
// beyond the white area's side and in its mirror image within the outermost nodes.
bool FarFit::IsPartOfLarger() const {
  const double half = family_.white_side() / 2.0;
  const double sign = family_.n() % 2 == 0 ? 1 : -1;  // whether the centre is a gap
  struct Strip {
    double grey = 0, product = 0, wave = 0, square = 0;
    int count = 0;
    void Add(double value, double w) {
      grey += value, wave += w, product += w * value, square += w * w;
      ++count;
    }
    double Amplitude() const {
      const double spread = square - wave * wave / std::max(count, 1);
      return spread > 0 ? (product - wave * grey / count) / spread : 0;
    }
  };
  Strip inside[4], outside[4];
  for (size_t i = 0; i < pixel_count_; ++i) {
    const Pixel& p = pixels_[i];
    const double w = 1 / (1 + map_[6] * p.x + map_[7] * p.y);
    const double u = (map_[0] * p.x + map_[1] * p.y + map_[2]) * w;
    const double v = (map_[3] * p.x + map_[4] * p.y + map_[5]) * w;
    for (int axis = 0; axis < 2; ++axis) {
      const double across = axis == 0 ? u : v, along = axis == 0 ? v : u;
      const double depth = std::abs(across) - half;
      if (std::abs(along) > half - 1 || std::abs(depth) > 2.8) continue;
      const int side = 2 * axis + (across > 0);
      if (depth > 0.2 && depth < 1.8) outside[side].Add(p.grey, sign * std::cos(M_PI / 2 * along));
      if (depth < -1.2 && depth > -2.8) inside[side].Add(p.grey, sign * std::cos(M_PI / 2 * along));
    }
  }
  bool goes_on[2] = {false, false};
  double reference = 0;
  for (const Strip& strip : inside) reference += strip.Amplitude() / 4;
  for (int side = 0; side < 4; ++side) {
    const double amplitude = outside[side].Amplitude();
    if (amplitude > kSurelyGoesOn * reference) return true;
    goes_on[side / 2] |= amplitude > kGoesOn * reference;
  }
  return goes_on[0] && goes_on[1];
}

}  // namespace topotag
