#include "host/far_model.h"

#include <algorithm>
#include <cmath>

namespace topotag {
namespace {

constexpr int kPitch = 64;      // in FarModel::kStep
constexpr double kReach = 5;    // of an edge, standard deviations
constexpr int kBeyond = 40;     // of the tables beyond the white area, in FarModel::kStep
constexpr int kHoleHalf = 128;  // of the holes' tables
// Below, the tables' steps show: at the sharp end of a steep marker's image.
constexpr double kMinSigma = 0.2;
constexpr double kMaxSigma = 4;

struct Quadrature {
  double correlation;  // up to which it serves
  int count;
  double place[4], weight[4];  // of the middle one and of those on one side of it
};

// Gauss-Hermite, for the standard normal distribution.
constexpr Quadrature kQuadratures[] = {
    {0.08, 1, {0}, {1}},
    {0.5, 3, {0, 1.7320508075688772}, {2.0 / 3, 1.0 / 6}},
    {0.75,
     5,
     {0, 1.3556261799742657, 2.8569700138728056},
     {0.5333333333333333, 0.2220759220056126, 0.011257411327720688}},
    {1,
     7,
     {0, 1.1544053947399682, 2.3667594107345415, 3.750439717725742},
     {0.45714285714285713, 0.24012317860501273, 0.030757123967586497, 5.482688559722179e-4}},
};

}  // namespace

void FarModel::Set(Family family, const Shape& shape, const double covariance[3],
                   double tolerance) {
  const double xx = covariance[0];
  const double yy = covariance[2];
  double correlation = std::min(std::abs(covariance[1]) / std::sqrt(xx * yy), 0.97);
  const auto* quadrature =
      std::find_if(std::begin(kQuadratures), std::end(kQuadratures) - 1,
                   [&](const Quadrature& q) { return correlation <= q.correlation; });
  shifts_ = quadrature->count;
  if (shifts_ == 1) correlation = 0;
  const double along_x = std::sqrt(correlation * xx);
  const double along_y = std::copysign(std::sqrt(correlation * yy), covariance[1]);
  for (int i = 0; i < shifts_; ++i) {
    const int k = (i + 1) / 2;
    const double place = i % 2 == 0 ? quadrature->place[k] : -quadrature->place[k];
    shift_x_[i] = static_cast<float>(place * along_x);
    shift_y_[i] = static_cast<float>(place * along_y);
    weight_[i] = static_cast<float>(quadrature->weight[k]);
  }
  if (!(family == family_) || shape.node != shape_.node) x_.sigma = y_.sigma = 0;
  family_ = family;
  shape_ = shape;
  half_ = 8 * family.white_side() + kBeyond;
  Fill(&x_, std::sqrt((1 - correlation) * xx), tolerance, true);
  Fill(&y_, std::sqrt((1 - correlation) * yy), tolerance, false);
}

void FarModel::Fill(Table* table, double sigma, double tolerance, bool along_x) {
  sigma = std::clamp(sigma, kMinSigma, kMaxSigma);
  if (std::abs(sigma - table->sigma) < tolerance * table->sigma) return;
  // One edge: from 0 to 1 over 2 reach + 1 steps.
  const int reach = static_cast<int>(std::ceil(kReach * sigma / kStep));
  const auto edge_size = static_cast<size_t>(2 * reach + 1);
  step_.Reserve(edge_size);
  density_.Reserve(edge_size);
  slope_.Reserve(edge_size);
  const int size = 2 * half_ + 1;
  table->entries.Reserve(static_cast<size_t>(size));
  table->hole.Reserve(2 * kHoleHalf + 1);
  // Not before there is memory for it: a failure leaves the table as one that is to be filled.
  table->sigma = static_cast<float>(sigma);
  for (int i = -reach; i <= reach; ++i) {
    const double t = i * kStep / sigma;
    const double density = std::exp(-0.5 * t * t) / (sigma * std::sqrt(2 * M_PI));
    const auto k = static_cast<size_t>(i + reach);
    step_[k] = static_cast<float>(0.5 * std::erfc(-t * M_SQRT1_2));
    density_[k] = static_cast<float>(density);
    slope_[k] = static_cast<float>(-density * t / sigma);
  }
  Entry* entries = table->entries.data();
  const Quad one = {1, 1, along_x ? 1.0F : 0.0F, along_x ? 1.0F : 0.0F};
  const Quad first = along_x ? Quad{1, 0, 1, 1} : one;
  for (int i = 0; i < size; ++i) {
    entries[i] = {Profile{Quad{}, Quad{}, Quad{}}, Profile{first, Quad{}, Quad{}}};
  }
  // Adds `height` from the edge on.
  const auto add = [&](Profile Entry::*profile, size_t lane, int edge, float height) {
    const int begin = half_ + edge - reach;
    const int end = std::min(begin + 2 * reach + 1, size);
    for (int i = std::max(begin, 0); i < end; ++i) {
      Profile& p = entries[i].*profile;
      const auto k = static_cast<size_t>(i - begin);
      p.value[lane] += height * step_[k];
      p.slope[lane] += height * density_[k];
      p.curvature[lane] += height * slope_[k];
    }
    for (int i = std::max(end, 0); i < size; ++i) (entries[i].*profile).value[lane] += height;
  };
  const auto add_box = [&](size_t lane, int center, int half, float height) {
    const int first = half_ + center - half, last = half_ + center + half;
    const int end = std::min(last + reach + 1, size);
    for (int i = std::max(first - reach, 0); i < end; ++i) {
      Profile& p = entries[i].shapes;
      const int a = i - first + reach, b = i - last + reach;
      if (a > 2 * reach) {
        p.value[lane] += height;
      } else {
        p.value[lane] += height * step_[static_cast<size_t>(a)];
        p.slope[lane] += height * density_[static_cast<size_t>(a)];
        p.curvature[lane] += height * slope_[static_cast<size_t>(a)];
      }
      if (b < 0) continue;
      p.value[lane] -= height * step_[static_cast<size_t>(b)];
      p.slope[lane] -= height * density_[static_cast<size_t>(b)];
      p.curvature[lane] -= height * slope_[static_cast<size_t>(b)];
    }
  };
  const int n = family_.n();
  const int white = 8 * family_.white_side();
  const int frame = white + 16;
  const int origin = -kPitch / 2 * (n - 1);
  for (int i = 0; i < n; ++i) add_box(0, origin + kPitch * i, shape_.node, 1);
  add_box(3, 0, white, 1);
  if (along_x) {
    add(&Entry::shapes, 1, origin - shape_.node, 1);
    add(&Entry::shapes, 1, origin + kPitch / 2 + shape_.node, -1);
    add_box(1, origin, shape_.node, -1);
    add_box(1, origin + kPitch, shape_.node, -1);
    add_box(2, origin, shape_.hole, 1);
    add_box(2, origin + kPitch / 2, shape_.hole, 1);
    add(&Entry::sides, 0, -frame, -1);
    add(&Entry::sides, 1, frame, 1);
    for (const size_t lane : {2, 3}) {
      for (int i = 0; i < size; ++i) entries[i].sides.value[lane] = 0;
      add(&Entry::sides, lane, -frame, 1);
      add(&Entry::sides, lane, frame, -1);
    }
  } else {
    add_box(1, origin, shape_.node, 1);
    add_box(2, origin, shape_.hole, 1);
    for (int i = 0; i < size; ++i) entries[i].sides.value[2] = 1;
    add(&Entry::sides, 2, -frame, -1);
    add(&Entry::sides, 3, frame, 1);
  }
  const auto at = [&](const Buffer<float>& edge, int place, float beyond) {
    if (place < -reach) return 0.0F;
    return place > reach ? beyond : edge[static_cast<size_t>(place + reach)];
  };
  for (int i = -kHoleHalf; i <= kHoleHalf; ++i) {
    const int a = i + shape_.hole;
    const int b = i - shape_.hole;
    table->hole[static_cast<size_t>(i + kHoleHalf)] = {at(step_, a, 1) - at(step_, b, 1),
                                                       at(density_, a, 0) - at(density_, b, 0),
                                                       at(slope_, a, 0) - at(slope_, b, 0)};
  }
}

FarModel::Entry FarModel::At(const Table& table, float place) const {
  const float position =
      std::clamp(place * static_cast<float>(1 / kStep) + static_cast<float>(half_), 0.0F,
                 static_cast<float>(2 * half_) - 0.01F);
  const auto index = static_cast<size_t>(position);
  const Quad t = MakeQuad(position - static_cast<float>(index));
  const Entry& a = table.entries[index];
  const Entry& b = table.entries[index + 1];
  const auto mix = [t](Quad from, Quad to) { return from + t * (to - from); };
  return {{mix(a.shapes.value, b.shapes.value), mix(a.shapes.slope, b.shapes.slope),
           mix(a.shapes.curvature, b.shapes.curvature)},
          {mix(a.sides.value, b.sides.value), mix(a.sides.slope, b.sides.slope),
           mix(a.sides.curvature, b.sides.curvature)}};
}

// Of the cells `cell` and `cell` + 1 along one axis: along x (0, 1, 0, 1), along y (0, 0, 1, 1).
FarModel::Profile FarModel::Holes(const Table& table, float place, int cell, bool along_x) const {
  Hole pair[2];
  for (int k = 0; k < 2; ++k) {
    const float center = static_cast<float>(4 * (cell + k) - 2 * (family_.n() - 1));
    const float position = std::clamp((place - center) * static_cast<float>(1 / kStep) + kHoleHalf,
                                      0.0F, 2.0F * kHoleHalf - 0.01F);
    const auto index = static_cast<size_t>(position);
    const float t = position - static_cast<float>(index);
    const Hole& a = table.hole[index];
    const Hole& b = table.hole[index + 1];
    pair[k] = {a.value + t * (b.value - a.value), a.slope + t * (b.slope - a.slope),
               a.curvature + t * (b.curvature - a.curvature)};
  }
  const Hole& p = pair[0];
  const Hole& q = pair[1];
  if (along_x) {
    return {Quad{p.value, q.value, p.value, q.value}, Quad{p.slope, q.slope, p.slope, q.slope},
            Quad{p.curvature, q.curvature, p.curvature, q.curvature}};
  }
  return {Quad{p.value, p.value, q.value, q.value}, Quad{p.slope, p.slope, q.slope, q.slope},
          Quad{p.curvature, p.curvature, q.curvature, q.curvature}};
}

FarCell FarModel::Cell(float u, float v) const {
  const auto n = family_.n();
  const auto cell = [n](float place) {
    const float cells = place / 4 + static_cast<float>(n + 1) / 2;
    return std::min(static_cast<int>(std::max(cells, 0.0F)) - 1, n - 1);
  };
  return {cell(u), cell(v)};
}

void FarModel::Evaluate(float u, float v, const FarCell& cell, const FarLevels& levels, Quad holes,
                        FarSample* sample) const {
  const Quad shapes = {levels.node, levels.node, -levels.node, -levels.frame};
  Quad basis{}, sides{}, hole_basis{};
  Quad sum{}, sum_u{}, sum_v{}, sum_uu{}, sum_vv{}, sum_uv{};
  for (int i = 0; i < shifts_; ++i) {
    const float x = u + shift_x_[i];
    const float y = v + shift_y_[i];
    const Entry ex = At(x_, x);
    const Entry ey = At(y_, y);
    const Profile hx = Holes(x_, x, cell.column, true);
    const Profile hy = Holes(y_, y, cell.row, false);
    const Quad weight = MakeQuad(weight_[i]);
    const auto add = [&](const Profile& px, const Profile& py, Quad amplitude, Quad* value) {
      const Quad product = weight * px.value * py.value;
      *value += product;
      const Quad a = weight * amplitude;
      const Quad ax = a * px.value;
      const Quad as = a * px.slope;
      sum += amplitude * product;
      sum_u += as * py.value;
      sum_v += ax * py.slope;
      sum_uu += a * px.curvature * py.value;
      sum_vv += ax * py.curvature;
      sum_uv += as * py.slope;
    };
    add(ex.shapes, ey.shapes, shapes, &basis);
    add(ex.sides, ey.sides, levels.sides, &sides);
    add(hx, hy, holes, &hole_basis);
  }
  sample->basis = {basis[0] + basis[1] - basis[2], 1 - basis[3], sides, hole_basis};
  sample->value = levels.white + levels.frame + SumLanes(sum);
  sample->u = SumLanes(sum_u);
  sample->v = SumLanes(sum_v);
  sample->uu = SumLanes(sum_uu);
  sample->vv = SumLanes(sum_vv);
  sample->uv = SumLanes(sum_uv);
}

}  // namespace topotag
