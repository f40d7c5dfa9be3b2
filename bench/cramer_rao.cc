#include "bench/cramer_rao.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>
#include <vector>

#include "host/cholesky.h"
#include "host/rotation.h"
#include "host/scene_levels.h"
#include "tests/scene_util.h"
#include "topotag/error.h"

namespace topotag::bench {
namespace {

constexpr size_t kPose = 6;
// Of an angle and of a share of the distance: where a pose is nearly unobservable, the corners
// would have to move too far for linear differences.
constexpr double kMaxStep = 0.02;
constexpr int kSamples = 8001;

using Levels = std::vector<double>;
/// Adds a value to one parameter of a scene.
using Shift = std::function<void(Scene*, double)>;

/// A parameter with the step of its central difference.
struct Parameter {
  Shift shift;
  double step;
};

Scene Shifted(const Scene& scene, const Shift& shift, double by) {
  Scene shifted = scene;
  shift(&shifted, by);
  return shifted;
}

Levels RenderArea(const Scene& scene, const Rect& area) {
  Levels levels;
  SceneLevels(scene).Render(area, &levels);
  return levels;
}

/// How far the corners move for a unit of a parameter, at most; pixels.
double Motion(const Scene& scene, const Shift& shift) {
  constexpr double kTiny = 1e-6;
  const Detection a = GroundTruth(Shifted(scene, shift, kTiny), 0), b = GroundTruth(scene, 0);
  double motion = 0;
  for (size_t i = 0; i < 4; ++i) {
    motion = std::max(motion, test::Distance(a.corners[i], b.corners[i]) / kTiny);
  }
  return motion;
}

std::vector<Parameter> PoseParameters(const Scene& scene, double step) {
  std::vector<Parameter> parameters;
  for (size_t i = 0; i < 3; ++i) {
    const Shift turn = [i](Scene* s, double by) {
      using test::operator*;
      Vector3 w{};
      w[i] = by;
      s->markers[0].R = Exp(w) * s->markers[0].R;
    };
    parameters.push_back({turn, std::min(step / Motion(scene, turn), kMaxStep)});
  }
  const double depth = test::Norm(scene.markers[0].t);
  for (size_t i = 0; i < 3; ++i) {
    const Shift move = [i](Scene* s, double by) { s->markers[0].t[i] += by; };
    parameters.push_back({move, std::min(step / Motion(scene, move), kMaxStep * depth)});
  }
  return parameters;
}

std::vector<Parameter> NuisanceParameters(const Scene& scene, double step) {
  const Detection truth = GroundTruth(scene, 0);
  const double side = test::Distance(truth.corners[0], truth.corners[1]);
  const double pixels_per_unit = side / truth.family.white_side();
  return {{[](Scene* s, double by) { s->markers[0].black += by; }, 1},
          {[](Scene* s, double by) { s->markers[0].white += by; }, 1},
          {[](Scene* s, double by) { s->background += by; }, 1},
          {[](Scene* s, double by) { s->blur += by; }, 0.5 * step},
          {[](Scene* s, double by) { s->markers[0].growth += by; },
           std::min(0.5 * step / pixels_per_unit, 0.1)}};
}

/// Derivatives of all pixels by each parameter, the six of the pose first.
std::vector<Levels> Derivatives(const Scene& scene, const Rect& area, double step) {
  std::vector<Parameter> parameters = PoseParameters(scene, step);
  for (Parameter& parameter : NuisanceParameters(scene, step)) {
    parameters.push_back(std::move(parameter));
  }
  std::vector<Levels> derivatives;
  for (const Parameter& p : parameters) {
    Levels high = RenderArea(Shifted(scene, p.shift, p.step), area);
    const Levels low = RenderArea(Shifted(scene, p.shift, -p.step), area);
    for (size_t i = 0; i < high.size(); ++i) high[i] = (high[i] - low[i]) / (2 * p.step);
    derivatives.push_back(std::move(high));
  }
  // The gain is 1 in the middle of the area, with a gradient along each axis.
  const Levels levels = RenderArea(scene, area);
  for (const bool along_x : {true, false}) {
    Levels gradient = levels;
    for (int y = 0; y < area.height; ++y) {
      for (int x = 0; x < area.width; ++x) {
        const double place = along_x ? x - area.width / 2.0 : y - area.height / 2.0;
        gradient[static_cast<size_t>(y) * area.width + x] *= place;
      }
    }
    derivatives.push_back(std::move(gradient));
  }
  return derivatives;
}

/// Inverse of the information matrix of all parameters, the part of the pose.
Matrix6 PoseCovariance(const std::vector<Levels>& derivatives, double variance) {
  const size_t n = derivatives.size();
  std::vector<double> information(n * n);
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = 0; j <= i; ++j) {
      information[i * n + j] = std::inner_product(derivatives[i].begin(), derivatives[i].end(),
                                                  derivatives[j].begin(), 0.0) /
                               variance;
    }
  }
  std::vector<double> inverse(n * n);
  if (!InvertPositive(information.data(), static_cast<int>(n), inverse.data())) {
    throw Error(ErrorCode::kInvalidArgument, "the pose cannot be told from these pixels");
  }
  Matrix6 covariance{};
  for (size_t i = 0; i < kPose; ++i) {
    for (size_t j = 0; j < kPose; ++j) covariance[i][j] = inverse[i * n + j];
  }
  return covariance;
}

Matrix3 Block(const Matrix6& m, size_t first) {
  Matrix3 block{};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) block[i][j] = m[first + i][first + j];
  }
  return block;
}

double Trace(const Matrix3& m) { return m[0][0] + m[1][1] + m[2][2]; }

Rect Enlarged(const Rect& area, int by, const Camera& camera) {
  const int x0 = std::max(area.x - by, 0), y0 = std::max(area.y - by, 0);
  return {x0, y0, std::min(area.x + area.width + by, camera.width) - x0,
          std::min(area.y + area.height + by, camera.height) - y0};
}

}  // namespace

PoseBound CramerRaoBound(const Scene& scene, double step) {
  const Rect area = Enlarged(SceneLevels(scene).Touched(0), 2, scene.camera);
  const double variance = scene.noise * scene.noise + 1.0 / 12;
  PoseBound bound;
  bound.covariance = PoseCovariance(Derivatives(scene, area, step), variance);
  const Matrix3 rotation = Block(bound.covariance, 0), position = Block(bound.covariance, 3);
  bound.median_position = MedianNorm(position);
  bound.median_rotation = MedianNorm(rotation);
  bound.rms_position = std::sqrt(Trace(position));
  bound.rms_rotation = std::sqrt(Trace(rotation));
  return bound;
}

double MedianNorm(const Matrix3& c) {
  // The Cholesky factor turns independent numbers into ones of this covariance; the scale of the
  // lengths is taken off before and given back after, so that tiny ones do not underflow.
  const double scale = std::sqrt(Trace(c));
  if (!(scale > 0)) return 0;
  Matrix3 l{};
  for (size_t j = 0; j < 3; ++j) {
    for (size_t i = j; i < 3; ++i) {
      double value = c[i][j] / (scale * scale);
      for (size_t k = 0; k < j; ++k) value -= l[i][k] * l[j][k];
      if (i == j) {
        l[i][j] = std::sqrt(std::max(value, 0.0));
      } else {
        l[i][j] = l[j][j] > 0 ? value / l[j][j] : 0;
      }
    }
  }
  test::Random random(1);
  std::vector<double> norms;
  for (int n = 0; n < kSamples; ++n) {
    const Vector3 z{random.Gaussian(), random.Gaussian(), random.Gaussian()};
    norms.push_back(test::Norm({l[0][0] * z[0], l[1][0] * z[0] + l[1][1] * z[1],
                                l[2][0] * z[0] + l[2][1] * z[1] + l[2][2] * z[2]}));
  }
  std::nth_element(norms.begin(), norms.begin() + kSamples / 2, norms.end());
  return scale * norms[kSamples / 2];
}

}  // namespace topotag::bench
