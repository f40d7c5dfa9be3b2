#include "bench/paper/statistics.h"

#include <algorithm>
#include <cmath>

#include "host/rigid_transform.h"
#include "tests/scene_util.h"

namespace topotag::bench::paper {
namespace {

constexpr double kMillimetres = 1e3;

}  // namespace

PoseDifference Difference(const PoseSolution& pose, const Matrix3& R, const Vector3& t) {
  return {kMillimetres * test::Distance(pose.t, t), test::AngleBetween(pose.R, R)};
}

MeanMax MeanMaxOf(const std::vector<double>& values) {
  MeanMax result;
  for (const double value : values) {
    ++result.count;
    result.mean += value;
    result.max = std::max(result.max, value);
  }
  if (result.count > 0) result.mean /= result.count;
  return result;
}

std::optional<PoseDifference> JitterOf(const std::vector<PoseSolution>& poses) {
  if (poses.size() < 2) return std::nullopt;
  const auto count = static_cast<double>(poses.size());
  // Rotations about the first one: a mean of rotation vectors would not do for large ones, such as
  // where the wrong solution of a planar pose comes and goes, but there it is large in any case.
  Vector3 mean_t{}, mean_w{};
  std::vector<Vector3> turns;
  for (const PoseSolution& pose : poses) {
    turns.push_back(RotationVector(pose.R * Transposed(poses[0].R)));
    for (size_t i = 0; i < 3; ++i) {
      mean_t[i] += pose.t[i] / count;
      mean_w[i] += turns.back()[i] / count;
    }
  }
  double t2 = 0, w2 = 0;
  for (size_t i = 0; i < poses.size(); ++i) {
    t2 += std::pow(test::Distance(poses[i].t, mean_t), 2) / count;
    w2 += std::pow(test::Distance(turns[i], mean_w), 2) / count;
  }
  return PoseDifference{kMillimetres * std::sqrt(t2), std::sqrt(w2) / test::kDegree};
}

std::optional<double> JitterOf(const std::vector<std::vector<Point2>>& frames) {
  if (frames.size() < 2 || frames[0].empty()) return std::nullopt;
  const auto count = static_cast<double>(frames.size());
  double sum = 0;
  for (size_t point = 0; point < frames[0].size(); ++point) {
    Point2 mean;
    for (const auto& points : frames) {
      mean.x += points[point].x / count;
      mean.y += points[point].y / count;
    }
    for (const auto& points : frames) sum += std::pow(test::Distance(points[point], mean), 2);
  }
  return std::sqrt(sum / count / static_cast<double>(frames[0].size()));
}

Cell Significant(std::optional<double> value) {
  if (!value) return {"none", std::nullopt};
  return Number(*value, *value < 0.1 ? 4 : *value < 1 ? 3 : *value < 10 ? 2 : 1);
}

}  // namespace topotag::bench::paper
