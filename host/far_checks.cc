#include <algorithm>
#include <cmath>

#include "host/cholesky.h"
#include "host/far_fit.h"

namespace topotag {
namespace {

// Of the modulation within the marker: on one side along each axis, on any side.
constexpr double kGoesOn = 0.35;
constexpr double kSurelyGoesOn = 0.8;

// A node's hole beside an offset of the node's own grey level.
constexpr double kBody = 1.5;      // half a side of what is looked at, units
constexpr double kAgainst = 8;     // nats by which the other bit may look better
constexpr double kResolved = 60;   // nats from which on the bit must look better
constexpr double kSureStep = 0.3;  // by so much of an ideal hole

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

// Whether each bit stands where its node may be brighter or darker as a whole, as a highlight makes
// it: a bright spot over a solid node is not taken for a hole then. What the image does not resolve
// so well counts as little as it tells.
bool FarFit::AreHolesLocal() {
  struct Sums {
    double count = 0, hole = 0, square = 0, rest = 0, product = 0;
  };
  Sums sums[kMaxVertices];
  for (size_t i = 0; i < pixel_count_; ++i) {
    const Pixel& p = pixels_[i];
    const double w = 1 / (1 + map_[6] * p.x + map_[7] * p.y);
    const auto u = static_cast<float>((map_[0] * p.x + map_[1] * p.y + map_[2]) * w);
    const auto v = static_cast<float>((map_[3] * p.x + map_[4] * p.y + map_[5]) * w);
    const double n = family_.n();
    const int column = static_cast<int>(std::floor(u / 4 + n / 2));
    const int row = static_cast<int>(std::floor(v / 4 + n / 2));
    const int h = Vertex(column, row);
    if (h < 0) continue;
    const double du = u - 4 * (column - (n - 1) / 2), dv = v - 4 * (row - (n - 1) / 2);
    if (std::abs(du) > kBody || std::abs(dv) > kBody) continue;
    const FarCell cell = model_.Cell(u, v);
    Quad holes{};
    float hole = 0;
    FarSample s;
    int own = -1;
    for (int k = 0; k < 4; ++k) {
      const int vertex = Vertex(cell.column + k % 2, cell.row + k / 2);
      if (vertex == h) own = k;
      if (vertex >= 0 && vertex != h) holes[k] = hole_[vertex];
    }
    if (own < 0) continue;
    model_.Evaluate(u, v, cell, levels_, holes, &s);
    const double gain = 1 + gain_[0] * u + gain_[1] * v;
    hole = s.basis.holes[own];
    const double rest = p.grey - gain * s.value, expected = gain * hole;
    Sums& sum = sums[h];
    sum.count += 1;
    sum.hole += expected;
    sum.square += expected * expected;
    sum.rest += rest;
    sum.product += expected * rest;
  }
  const double depth = -levels_.node, variance = Variance();
  for (int h = 2; h < family_.vertex_count(); ++h) {
    const Sums& s = sums[h];
    if (s.count < 3) continue;
    const double square = s.square - s.hole * s.hole / s.count;
    const double product = s.product - s.hole * s.rest / s.count;
    if (!(square > 0)) continue;
    const double sign = (bits_ >> h & 1) != 0 ? 1 : -1;
    // 1 for an ideal node of this bit, -1 for one of the other.
    const double step = sign * (2 * product / (depth * square) - 1);
    const double ideal = depth * depth * square / (2 * variance);
    if (ideal * step < -kAgainst || (ideal > kResolved && step < kSureStep)) return false;
  }
  return true;
}

}  // namespace topotag
