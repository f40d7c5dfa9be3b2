#include "host/node_levels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/levels.h"

namespace topotag {
namespace {

// Half sides of rectangles around the centre, units: in the middle of the gap, and of the body.
constexpr Point2 kGap{2, 2};
constexpr Point2 kBody{1, 1};
constexpr Point2 kBaselineGap{3, 2};
constexpr Point2 kBaselineBody{2, 1};
constexpr double kFineStep = 0.2;  // units from one outline in a fine gap to the next
// Sum of the squares of a ring's a, and of its b, which are in 4ths of a half side.
constexpr double kRingSquares = 168 / 16.0;
constexpr double kOne = 1 << kPlaceShift;
constexpr double kLevel = 1.0 / 256;

int32_t Fixed(double pixels) { return static_cast<int32_t>(pixels * kOne); }

Ring RingAt(const LocalMaps& maps, int i, Point2 half) {
  const double x = half.x / 4;
  const double y = half.y / 4;
  return {Fixed(maps.x[i]),      Fixed(maps.y[i]),      Fixed(maps.xu[i] * x),
          Fixed(maps.yu[i] * x), Fixed(maps.xv[i] * y), Fixed(maps.yv[i] * y)};
}

bool FitFixed(const LocalMaps& maps, int count) {
  bool fit = true;
  for (int i = 0; i < count; ++i) {
    const double reach = kBaselineGap.x * (std::abs(maps.xu[i]) + std::abs(maps.yu[i]) +
                                           std::abs(maps.xv[i]) + std::abs(maps.yv[i]));
    fit &= reach < kMaxImageSide / 4 && std::abs(maps.x[i]) < kMaxImageSide &&
           std::abs(maps.y[i]) < kMaxImageSide;
  }
  return fit;
}

// Sums over the outlines of a gap of the levels, and of them and of squares times their place in
// units. The points are symmetric to the centre in pairs, so that mean and gradient are
// independent.
struct GapSums {
  void Add(const RingSums& sums, Point2 half) {
    points += kRingPoints;
    white += sums.sum;
    moment.x += sums.a * half.x / 4;
    moment.y += sums.b * half.y / 4;
    square.x += half.x * half.x * kRingSquares;
    square.y += half.y * half.y * kRingSquares;
  }
  void Fit(NodeLevels* levels) const {
    levels->white = static_cast<float>(white * kLevel / points);
    levels->white_u = static_cast<float>(moment.x * kLevel / square.x);
    levels->white_v = static_cast<float>(moment.y * kLevel / square.y);
  }

  int points = 0;
  double white = 0;
  Point2 moment, square;
};

}  // namespace

bool MeasureLevels(const ImageView& image, Family family, const LocalMaps& maps, NodeLevels* levels,
                   float* holes) {
  const int vertices = family.vertex_count();
  const int count = vertices + 1;
  if (!FitFixed(maps, count)) return false;
  // The bodies, the gaps from vertex 2 on, two more outlines of each gap that is fine.
  Ring rings[4 * kMaxPoints];
  RingSums sums[4 * kMaxPoints];
  int size = 0;
  for (int i = 0; i < vertices; ++i) rings[size++] = RingAt(maps, i, kBody);
  rings[size++] = RingAt(maps, vertices, kBaselineBody);
  const auto gap_of = [&](int i) { return i == vertices ? kBaselineGap : kGap; };
  for (int i = 2; i < count; ++i) rings[size++] = RingAt(maps, i, gap_of(i));
  const int fine = size;
  const auto is_fine = [&](int i) { return std::abs(maps.Determinant(i)) >= kFineArea; };
  for (int i = 2; i < count; ++i) {
    if (!is_fine(i)) continue;
    const Point2 gap = gap_of(i);
    rings[size++] = RingAt(maps, i, {gap.x - kFineStep, gap.y - kFineStep});
    rings[size++] = RingAt(maps, i, {gap.x + kFineStep, gap.y + kFineStep});
  }
  SumRings(image, rings, size, sums);

  for (int i = 0; i < count; ++i) {
    levels[i].black = static_cast<float>(sums[i].sum * kLevel / kRingPoints);
  }
  const RingSums* beside = sums + fine;
  for (int i = 2; i < count; ++i) {
    const Point2 gap = gap_of(i);
    GapSums gap_sums;
    gap_sums.Add(sums[count + i - 2], gap);
    if (is_fine(i)) {
      gap_sums.Add(*beside++, {gap.x - kFineStep, gap.y - kFineStep});
      gap_sums.Add(*beside++, {gap.x + kFineStep, gap.y + kFineStep});
    }
    gap_sums.Fit(&levels[i]);
  }

  int32_t x[kMaxVertices], y[kMaxVertices], at_center[kMaxVertices];
  for (int i = 0; i < vertices; ++i) {
    x[i] = rings[i].x;
    y[i] = rings[i].y;
  }
  const int padded = (vertices + kRingPoints - 1) / kRingPoints * kRingPoints;
  std::fill(x + vertices, x + padded, 0);
  std::fill(y + vertices, y + padded, 0);
  SampleLevels(image, x, y, vertices, at_center);
  for (int i = 0; i < vertices; ++i) holes[i] = static_cast<float>(at_center[i] * kLevel);
  return true;
}

}  // namespace topotag
