#include "host/pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "host/model.h"
#include "host/pair.h"
#include "host/planar_pose.h"
#include "host/vertices.h"

namespace topotag {
namespace {

constexpr int kMaxIterations = 12;
// A solution is done where the next step would improve the error's norm by less than this.
constexpr double kStop = 1e-4;  // pixels
// The other solution is done where its cost would fall by less than this part, and stays several
// times the better one's.
constexpr double kRoughStop = 1e-3;
constexpr double kRoughRatio = 4;
constexpr double kMinSigma = 0.01;      // of one vertex coordinate, pixels: floor of the covariance
constexpr double kSameRotation = 2e-3;  // rad: solutions this close are one
constexpr double kMinDepth = 1e-9;
// Errors that all vertices of a small marker share, in units of the marker: this at no pixel a unit
// in the steepest direction, a factor e less with each so many pixels more. Measured on renders.
constexpr double kSharedError = 0.22;
constexpr double kSharedErrorFall = 1.9;

struct Problem {
  const Camera& camera;
  int count;
  const Point2* model;
  const VertexList& vertices;
  uint64_t unmeasured;  ///< vertices without weight

  int measured() const { return count - __builtin_popcountll(unmeasured); }
};

// Symmetric 3 x 3 matrix.
template <typename T>
struct Symmetric3 {
  T xx, xy, xz, yy, yz, zz;

  std::array<T, 3> operator*(const std::array<T, 3>& v) const {
    return {xx * v[0] + xy * v[1] + xz * v[2], xy * v[0] + yy * v[1] + yz * v[2],
            xz * v[0] + yz * v[1] + zz * v[2]};
  }
  Symmetric3 Inverse() const {
    const T a = yy * zz - yz * yz, b = xz * yz - xy * zz, c = xy * yz - xz * yy;
    const T s = 1 / (xx * a + xy * b + xz * c);
    return {a * s,
            b * s,
            c * s,
            (xx * zz - xz * xz) * s,
            (xy * xz - xx * yz) * s,
            (xx * yy - xy * xy) * s};
  }
};

// Gauss-Newton system of the weighted reprojection errors for (w, dt): R' = exp(w) R, t' = t + dt.
template <typename T>
struct Equations {
  T cost;     ///< sum of weighted squares; infinite with a vertex behind the camera
  T squares;  ///< the same without weights
  Symmetric3<T> rotation, translation;
  std::array<std::array<T, 3>, 3> mixed;  ///< rows: w, columns: dt
  std::array<T, 3> rotation_gradient, translation_gradient;

  // Adds a point of the marker, rotated to the camera's axes: the matrix m and the gradient g of
  // its errors' squares by its place in the camera. d place / d w = -[rotated]_x.
  void Add(const std::array<T, 3>& p, const Symmetric3<T>& m, const std::array<T, 3>& g) {
    translation.xx += m.xx;
    translation.xy += m.xy;
    translation.xz += m.xz;
    translation.yy += m.yy;
    translation.yz += m.yz;
    translation.zz += m.zz;
    const std::array<T, 3> columns[3] = {Cross<T>(p, {m.xx, m.xy, m.xz}),
                                         Cross<T>(p, {m.xy, m.yy, m.yz}),
                                         Cross<T>(p, {m.xz, m.yz, m.zz})};
    const std::array<T, 3> turned = Cross(p, g);
    for (size_t i = 0; i < 3; ++i) {
      for (size_t k = 0; k < 3; ++k) mixed[i][k] += columns[k][i];
      translation_gradient[i] += g[i];
      rotation_gradient[i] += turned[i];
    }
    rotation.xx += p[1] * columns[2][0] - p[2] * columns[1][0];
    rotation.xy += p[2] * columns[0][0] - p[0] * columns[2][0];
    rotation.xz += p[0] * columns[1][0] - p[1] * columns[0][0];
    rotation.yy += p[2] * columns[0][1] - p[0] * columns[2][1];
    rotation.yz += p[0] * columns[1][1] - p[1] * columns[0][1];
    rotation.zz += p[0] * columns[1][2] - p[1] * columns[0][2];
  }
};

using System = Equations<double>;

System Sum(const Equations<Pair>& pairs) {
  static_assert(sizeof(Equations<Pair>) == 2 * sizeof(System));
  constexpr size_t kValues = sizeof(System) / sizeof(double);
  std::array<Pair, kValues> in;
  std::array<double, kValues> out;
  std::memcpy(in.data(), &pairs, sizeof(pairs));
  for (size_t i = 0; i < kValues; ++i) out[i] = in[i][0] + in[i][1];
  System sum;
  std::memcpy(&sum, out.data(), sizeof(sum));
  return sum;
}

// Pixels of a pair of normalised points, and their derivatives (row-major).
template <bool kLens>
void ProjectPair(const Camera& camera, Pair x, Pair y, Pair pixel[2], Pair jacobian[4]) {
  if (!kLens) {
    pixel[0] = camera.fx * x + camera.cx;
    pixel[1] = camera.fy * y + camera.cy;
    jacobian[0] = Pair{camera.fx, camera.fx};
    jacobian[3] = Pair{camera.fy, camera.fy};
    return;
  }
  for (int lane = 0; lane < 2; ++lane) {
    Jacobian2 j;
    const Point2 p = Project(camera, {x[lane], y[lane]}, &j);
    pixel[0][lane] = p.x;
    pixel[1][lane] = p.y;
    for (size_t k = 0; k < 4; ++k) jacobian[k][lane] = j[k];
  }
}

template <bool kLens>
System Evaluate(const Problem& problem, const Rigid& pose) {
  Equations<Pair> sums{};
  Pair nearest = {INFINITY, INFINITY};
  for (int i = 0; i < problem.count; i += 2) {
    const int second = i + 1 < problem.count ? i + 1 : i;  // an odd last vertex: no weight
    const Point2 p[2] = {problem.model[i], problem.model[second]};
    const Pair px = {p[0].x, p[1].x};
    const Pair py = {p[0].y, p[1].y};
    const std::array<Pair, 3> rotated{pose.x[0] * px + pose.y[0] * py,
                                      pose.x[1] * px + pose.y[1] * py,
                                      pose.x[2] * px + pose.y[2] * py};
    const Pair z = rotated[2] + pose.t[2];
    nearest = z < nearest ? z : nearest;
    const Pair iz = 1 / z;
    const Pair qx = (rotated[0] + pose.t[0]) * iz;
    const Pair qy = (rotated[1] + pose.t[1]) * iz;
    Pair pixel[2];
    Pair j[4];
    ProjectPair<kLens>(problem.camera, qx, qy, pixel, j);
    const Pair ex = pixel[0] - Pair{problem.vertices[i].x, problem.vertices[second].x};
    const Pair ey = pixel[1] - Pair{problem.vertices[i].y, problem.vertices[second].y};
    const double first_weight = i == 0 ? kBaselineWeight : 1;  // p1 and p2 are one pair
    const Pair once = {problem.unmeasured >> i & 1 ? 0.0 : 1.0,
                       second == i || (problem.unmeasured >> second & 1) ? 0.0 : 1.0};
    const Pair weight = first_weight * once;
    const Pair squares = ex * ex + ey * ey;
    sums.cost += weight * squares;
    sums.squares += once * squares;
    // Derivatives of the pixel by the place in the camera: (a, b, -(a, b) q) / z for each row.
    const Pair w = weight * iz;
    const Pair w2 = w * iz;
    Symmetric3<Pair> m;
    std::array<Pair, 3> g;
    if (kLens) {
      m.xx = w2 * (j[0] * j[0] + j[2] * j[2]);
      m.xy = w2 * (j[0] * j[1] + j[2] * j[3]);
      m.yy = w2 * (j[1] * j[1] + j[3] * j[3]);
      m.xz = -(m.xx * qx + m.xy * qy);
      m.yz = -(m.xy * qx + m.yy * qy);
      g[0] = w * (j[0] * ex + j[2] * ey);
      g[1] = w * (j[1] * ex + j[3] * ey);
    } else {
      m.xx = w2 * (j[0] * j[0]);
      m.xy = Pair{};
      m.yy = w2 * (j[3] * j[3]);
      m.xz = -(m.xx * qx);
      m.yz = -(m.yy * qy);
      g[0] = w * (j[0] * ex);
      g[1] = w * (j[3] * ey);
    }
    m.zz = -(m.xz * qx + m.yz * qy);
    g[2] = -(g[0] * qx + g[1] * qy);
    sums.Add(rotated, m, g);
  }
  System system = Sum(sums);
  if (!(nearest[0] > kMinDepth && nearest[1] > kMinDepth)) system.cost = INFINITY;
  return system;
}

System Evaluate(const Problem& problem, const Rigid& pose) {
  return problem.camera.model == DistortionModel::kNone ? Evaluate<false>(problem, pose)
                                                        : Evaluate<true>(problem, pose);
}

// A system's matrix with the translation eliminated.
struct Eliminated {
  // @param damping  the diagonal grows by this part
  Eliminated(const System& system, double damping) {
    Symmetric3<double> c = system.translation;
    Symmetric3<double> a = system.rotation;
    for (double* value : {&c.xx, &c.yy, &c.zz, &a.xx, &a.yy, &a.zz}) *value *= 1 + damping;
    translation = c.Inverse();
    const Matrix3& b = system.mixed;
    for (size_t i = 0; i < 3; ++i) gain[i] = translation * b[i];
    a.xx -= Dot(gain[0], b[0]);
    a.xy -= Dot(gain[0], b[1]);
    a.xz -= Dot(gain[0], b[2]);
    a.yy -= Dot(gain[1], b[1]);
    a.yz -= Dot(gain[1], b[2]);
    a.zz -= Dot(gain[2], b[2]);
    rotation = a.Inverse();
  }

  Symmetric3<double> rotation;     ///< covariance of w
  Symmetric3<double> translation;  ///< covariance of dt at a known w
  Matrix3 gain;                    ///< rows: w; dt changes by -gain' w
};

struct Step {
  Vector3 w, dt;
  double gain;  ///< expected fall of the cost
};

Step Solve(const System& system, double damping) {
  const Eliminated e(system, damping);
  const Vector3& g = system.rotation_gradient;
  const Vector3& h = system.translation_gradient;
  Step step;
  step.w = e.rotation *
           Vector3{Dot(e.gain[0], h) - g[0], Dot(e.gain[1], h) - g[1], Dot(e.gain[2], h) - g[2]};
  step.dt = e.translation * Scaled(h, -1);
  for (size_t k = 0; k < 3; ++k) {
    for (size_t i = 0; i < 3; ++i) step.dt[k] -= e.gain[i][k] * step.w[i];
  }
  step.gain = -Dot(g, step.w) - Dot(h, step.dt);
  return step;
}

// The pose after a step; the rotation by w is that of the quaternion (1, w / 2), which is exp(w) to
// second order.
Rigid Apply(const Rigid& pose, const Step& step) {
  const Vector3 half = Scaled(step.w, 0.5);
  const double scale = 2 / (1 + Dot(half, half));
  const auto rotate = [&](const Vector3& v) {
    const Vector3 once = Cross(half, v);
    const Vector3 twice = Cross(half, once);
    return Vector3{v[0] + scale * (once[0] + twice[0]), v[1] + scale * (once[1] + twice[1]),
                   v[2] + scale * (once[2] + twice[2])};
  };
  return {rotate(pose.x),
          rotate(pose.y),
          {pose.t[0] + step.dt[0], pose.t[1] + step.dt[1], pose.t[2] + step.dt[2]}};
}

struct Solution {
  Rigid pose;
  System system;
};

// Levenberg-Marquardt.
// @param better  cost of the other solution, if it is known to be the better one, else infinite
void Refine(const Problem& problem, double better, Solution* solution) {
  double damping = 1e-6;
  for (int i = 0; i < kMaxIterations && std::isfinite(solution->system.cost); ++i) {
    const double cost = solution->system.cost;
    const Step step = Solve(solution->system, damping);
    if (!(step.gain > kStop * kStop) ||
        (step.gain < kRoughStop * cost && cost > kRoughRatio * better)) {
      break;
    }
    const Rigid next = Apply(solution->pose, step);
    const System system = Evaluate(problem, next);
    if (system.cost < cost) {
      *solution = {next, system};
      damping /= 10;
    } else {
      damping = std::max(damping * 10, 1e-3);
    }
  }
  Orthonormalize(&solution->pose);
}

PoseSolution ToSolution(const Problem& problem, const Solution& solution, double unit) {
  const Rigid& pose = solution.pose;
  const Vector3 z = Cross(pose.x, pose.y);
  PoseSolution result;
  for (size_t r = 0; r < 3; ++r) result.R[r] = {pose.x[r], pose.y[r], z[r]};
  result.t = Scaled(pose.t, unit);
  result.rms_px = std::sqrt(solution.system.squares / problem.measured());
  return result;
}

// Standard deviation of what a pose suffers from beside noise, as if it were noise of the vertices:
// what blur moves in common residuals do not show. Pixels.
double SharedError(const Camera& camera, const Rigid& pose) {
  const Point2 q{pose.t[0] / pose.t[2], pose.t[1] / pose.t[2]};
  Jacobian2 j;
  Project(camera, q, &j);
  // Pixels by one unit of each axis.
  const auto along = [&](const Vector3& axis) {
    const double x = (axis[0] - q.x * axis[2]) / pose.t[2];
    const double y = (axis[1] - q.y * axis[2]) / pose.t[2];
    return Point2{j[0] * x + j[1] * y, j[2] * x + j[3] * y};
  };
  const Point2 u = along(pose.x);
  const Point2 v = along(pose.y);
  const double mean = 0.5 * (u.x * u.x + u.y * u.y + v.x * v.x + v.y * v.y);
  const double area = std::abs(u.x * v.y - u.y * v.x);
  const double longest = std::sqrt(mean + std::sqrt(std::max(mean * mean - area * area, 0.0)));
  return longest * kSharedError * std::exp(-kSharedErrorFall * area / longest);
}

// Variance of a vertex coordinate from the residuals and the shared error, times the inverse of the
// normal matrix; translation rows and columns in metres.
Matrix6 Covariance(const Problem& problem, const Solution& solution, double unit) {
  const System& system = solution.system;
  const double shared = SharedError(problem.camera, solution.pose);
  const double variance =
      std::max(system.cost / (2 * problem.measured() - 6), kMinSigma * kMinSigma) + shared * shared;
  const Eliminated e(system, 0);
  const Symmetric3<double>& s = e.rotation;
  const Symmetric3<double>& c = e.translation;
  const Matrix3 rotation{{{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}}};
  const Matrix3 translation{{{c.xx, c.xy, c.xz}, {c.xy, c.yy, c.yz}, {c.xz, c.yz, c.zz}}};
  Matrix6 covariance;
  Matrix3 mixed{};  // of w and dt: -rotation gain
  for (size_t i = 0; i < 3; ++i) {
    for (size_t k = 0; k < 3; ++k) {
      for (size_t m = 0; m < 3; ++m) mixed[i][k] -= rotation[i][m] * e.gain[m][k];
      covariance[i][k] = variance * rotation[i][k];
      covariance[i][k + 3] = covariance[k + 3][i] = variance * mixed[i][k] * unit;
    }
  }
  for (size_t i = 0; i < 3; ++i) {
    for (size_t k = 0; k <= i; ++k) {
      double value = translation[i][k];
      for (size_t m = 0; m < 3; ++m) value -= e.gain[m][i] * mixed[m][k];
      covariance[i + 3][k + 3] = covariance[k + 3][i + 3] = variance * value * unit * unit;
    }
  }
  return covariance;
}

// The sine of half the angle between two rotations is that of 8 squares' sum.
bool IsSameRotation(const Rigid& a, const Rigid& b) {
  const Vector3 az = Cross(a.x, a.y);
  const Vector3 bz = Cross(b.x, b.y);
  double sum = 0;
  for (size_t i = 0; i < 3; ++i) {
    const double x = a.x[i] - b.x[i], y = a.y[i] - b.y[i], z = az[i] - bz[i];
    sum += x * x + y * y + z * z;
  }
  // 8 sin^2(angle / 2), here 2 angle^2.
  return sum <= 2 * kSameRotation * kSameRotation;
}

Homography ToNormalized(const Homography& map, const Camera& camera) {
  Homography normalized = map;
  for (size_t c = 0; c < 3; ++c) {
    normalized.m[0][c] = (map.m[0][c] - camera.cx * map.m[2][c]) / camera.fx;
    normalized.m[1][c] = (map.m[1][c] - camera.cy * map.m[2][c]) / camera.fy;
  }
  return normalized;
}

}  // namespace

bool EstimatePose(Family family, const VertexList& vertices, const Homography& map,
                  const Camera& camera, double tag_size, Pose* pose, uint64_t unmeasured) {
  const Problem problem{camera, family.vertex_count(), ModelTable(family), vertices, unmeasured};
  Rigid start[2];
  if (!PlanarPoses(ToNormalized(map, camera), start)) return false;
  Solution best{start[0], Evaluate(problem, start[0])};
  Solution other{start[1], Evaluate(problem, start[1])};
  if (other.system.cost < best.system.cost) std::swap(best, other);
  Refine(problem, INFINITY, &best);
  Refine(problem, best.system.cost, &other);
  if (other.system.cost < best.system.cost) std::swap(best, other);
  if (!std::isfinite(best.system.cost)) return false;

  const double unit = tag_size / family.white_side();
  static_cast<PoseSolution&>(*pose) = ToSolution(problem, best, unit);
  pose->covariance = Covariance(problem, best, unit);
  pose->alternative.reset();
  pose->ambiguity = 0;
  pose->photometric.reset();
  if (std::isfinite(other.system.cost) && !IsSameRotation(best.pose, other.pose)) {
    pose->alternative = ToSolution(problem, other, unit);
    pose->ambiguity = pose->rms_px / std::max(pose->alternative->rms_px, kMinDepth);
  }
  return true;
}

}  // namespace topotag
