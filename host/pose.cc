#include "host/pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "host/vertices.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr int kMaxIterations = 12;
constexpr double kStop = 1e-4;          // pixels of predicted improvement of the error's norm
constexpr double kMinSigma = 0.01;      // of one vertex coordinate, pixels: floor of the covariance
constexpr double kSameRotation = 2e-3;  // rad: solutions this close are one
constexpr double kMinDepth = 1e-9;

// x_camera = R x_tag + t, lengths in units.
struct Rigid {
  Matrix3d R;
  Vector3d t;
};

struct Problem {
  const Camera& camera;
  int count;
  std::array<Point2, kMaxVertices> model;
  const VertexList& vertices;
};

// Translation that best projects the model under R: linear least squares in normalised
// coordinates of the homography.
Vector3d SolveTranslation(const Problem& problem, const Homography& normalized, const Matrix3d& R) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (int i = 0; i < problem.count; ++i) {
    const Point2 p = problem.model[static_cast<size_t>(i)];
    const Point2 q = normalized.Map(p);
    const Vector3d x = R.col(0) * p.x + R.col(1) * p.y;
    // t_x - q.x t_z = q.x x_z - x_x, and the same for y.
    const Vector3d rows[2] = {{1, 0, -q.x}, {0, 1, -q.y}};
    const double values[2] = {q.x * x.z() - x.x(), q.y * x.z() - x.y()};
    for (int k = 0; k < 2; ++k) {
      normal += rows[k] * rows[k].transpose();
      right += rows[k] * values[k];
    }
  }
  return normal.ldlt().solve(right);
}

// Rotation that takes the z axis to the direction of (v, 1), about an axis in the image plane.
Matrix3d RotationToRay(const Vector2d& v) {
  const Vector3d ray = Vector3d(v.x(), v.y(), 1).normalized();
  Matrix3d k;  // cross product with z x ray
  k << 0, 0, ray.x(), 0, 0, ray.y(), -ray.x(), -ray.y(), 0;
  return Matrix3d::Identity() + k + k * k / (1 + ray.z());
}

// The two rotations of infinitesimal plane-based pose estimation at the model's origin.
bool PlanarRotations(const Homography& normalized, Matrix3d rotations[2]) {
  Jacobian2 jacobian;
  const Point2 center = normalized.Map({0, 0}, &jacobian);
  const Vector2d v(center.x, center.y);
  const Matrix3d Rv = RotationToRay(v);
  Matrix2d J;
  J << jacobian[0], jacobian[1], jacobian[2], jacobian[3];
  const Matrix2d B = Rv.topLeftCorner<2, 2>() - v * Rv.row(2).head<2>();
  const Matrix2d A = B.inverse() * J;
  // The larger singular value of A is the scale 1 / depth.
  const Matrix2d AAt = A * A.transpose();
  const double trace = AAt.trace();
  const double det = AAt.determinant();
  const double gamma = std::sqrt((trace + std::sqrt(std::max(trace * trace - 4 * det, 0.0))) / 2);
  if (!(gamma > 0) || !std::isfinite(gamma)) return false;
  const Matrix2d R22 = A / gamma;
  const Matrix2d rest = Matrix2d::Identity() - R22.transpose() * R22;
  const double b0 = std::sqrt(std::max(rest(0, 0), 0.0));
  const double b1 = std::copysign(std::sqrt(std::max(rest(1, 1), 0.0)), rest(0, 1));
  for (int k = 0; k < 2; ++k) {
    const double sign = k == 0 ? 1 : -1;
    const Vector3d c0(R22(0, 0), R22(1, 0), sign * b0);
    const Vector3d c1(R22(0, 1), R22(1, 1), sign * b1);
    Matrix3d R;
    R << c0, c1, c0.cross(c1);
    // Noise leaves the columns slightly off a rotation.
    rotations[k] = Eigen::Quaterniond(Rv * R).normalized().toRotationMatrix();
  }
  return true;
}

// Sum of weighted squared reprojection errors, and with `normal` its Gauss-Newton system for
// (w, dt): R' = exp(w) R, t' = t + dt. Infinite where a vertex is not in front of the camera.
double Evaluate(const Problem& problem, const Rigid& pose, Matrix6d* normal, Vector6d* gradient) {
  double cost = 0;
  if (normal != nullptr) {
    normal->setZero();
    gradient->setZero();
  }
  for (int i = 0; i < problem.count; ++i) {
    const Point2 p = problem.model[static_cast<size_t>(i)];
    const Vector3d rotated = pose.R.col(0) * p.x + pose.R.col(1) * p.y;
    const Vector3d x = rotated + pose.t;
    if (!(x.z() > kMinDepth)) return INFINITY;
    const double iz = 1 / x.z();
    const Point2 normalized{x.x() * iz, x.y() * iz};
    Jacobian2 lens;
    const Point2 pixel = Project(problem.camera, normalized, normal != nullptr ? &lens : nullptr);
    const double error[2] = {pixel.x - problem.vertices[i].x, pixel.y - problem.vertices[i].y};
    const double weight = i < 2 ? kBaselineWeight : 1;
    cost += weight * (error[0] * error[0] + error[1] * error[1]);
    if (normal == nullptr) continue;
    for (int k = 0; k < 2; ++k) {
      // d pixel / d x_camera; then d x_camera / d w = -[rotated]_x, d x_camera / d dt = I.
      const Vector3d d(lens[2 * k] * iz, lens[2 * k + 1] * iz,
                       -(lens[2 * k] * normalized.x + lens[2 * k + 1] * normalized.y) * iz);
      Vector6d row;
      row << rotated.cross(d), d;
      *gradient += (weight * error[k]) * row;
      for (int r = 0; r < 6; ++r) {
        const double scaled = weight * row[r];
        for (int c = 0; c <= r; ++c) (*normal)(r, c) += scaled * row[c];
      }
    }
  }
  return cost;
}

Matrix3d Exp(const Vector3d& w) {
  const double angle = w.norm();
  if (angle < 1e-12) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

// Levenberg-Marquardt; returns the final cost.
double Refine(const Problem& problem, Rigid* pose) {
  Matrix6d normal;
  Vector6d gradient;
  double cost = Evaluate(problem, *pose, &normal, &gradient);
  double lambda = 1e-6;
  for (int iteration = 0; iteration < kMaxIterations && std::isfinite(cost); ++iteration) {
    Matrix6d damped = normal;
    damped.diagonal() *= 1 + lambda;
    const Vector6d step = damped.ldlt().solve(-gradient);
    if (!step.allFinite()) break;
    Rigid next{Exp(step.head<3>()) * pose->R, pose->t + step.tail<3>()};
    Matrix6d next_normal;
    Vector6d next_gradient;
    const double next_cost = Evaluate(problem, next, &next_normal, &next_gradient);
    if (!(next_cost < cost)) {
      if (-gradient.dot(step) <= kStop * kStop) break;
      lambda = std::max(lambda * 10, 1e-3);
      continue;
    }
    const double gain = cost - next_cost;
    *pose = next;
    normal = next_normal;
    gradient = next_gradient;
    cost = next_cost;
    lambda /= 10;
    if (gain <= kStop * kStop) break;
  }
  pose->R = Eigen::Quaterniond(pose->R).normalized().toRotationMatrix();
  return cost;
}

PoseSolution ToSolution(const Problem& problem, const Rigid& pose, double unit) {
  PoseSolution solution;
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c)
      solution.R[r][c] = pose.R(static_cast<int>(r), static_cast<int>(c));
    solution.t[r] = pose.t[static_cast<int>(r)] * unit;
  }
  double sum = 0;
  for (int i = 0; i < problem.count; ++i) {
    const Point2 p = problem.model[static_cast<size_t>(i)];
    const Vector3d x = pose.R.col(0) * p.x + pose.R.col(1) * p.y + pose.t;
    const Point2 pixel = Project(problem.camera, {x.x() / x.z(), x.y() / x.z()});
    const double dx = pixel.x - problem.vertices[i].x;
    const double dy = pixel.y - problem.vertices[i].y;
    sum += dx * dx + dy * dy;
  }
  solution.rms_px = std::sqrt(sum / problem.count);
  return solution;
}

// Variance of a vertex coordinate from the residuals, times the inverse of the normal matrix;
// translation rows and columns in metres.
Matrix6 Covariance(const Problem& problem, const Rigid& pose, double unit) {
  Matrix6d normal;
  Vector6d gradient;
  const double cost = Evaluate(problem, pose, &normal, &gradient);
  const double variance = std::max(cost / (2 * problem.count - 6), kMinSigma * kMinSigma);
  const Matrix6d inverse =
      normal.selfadjointView<Eigen::Lower>().ldlt().solve(Matrix6d::Identity());
  Matrix6 covariance;
  for (size_t r = 0; r < 6; ++r) {
    for (size_t c = 0; c < 6; ++c) {
      // Mean of both triangles: exactly symmetric whatever the rounding.
      const double value = 0.5 * (inverse(static_cast<int>(r), static_cast<int>(c)) +
                                  inverse(static_cast<int>(c), static_cast<int>(r)));
      covariance[r][c] = variance * value * (r < 3 ? 1 : unit) * (c < 3 ? 1 : unit);
    }
  }
  return covariance;
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
                  const Camera& camera, double tag_size, Pose* pose) {
  Problem problem{camera, family.vertex_count(), {}, vertices};
  for (int i = 0; i < problem.count; ++i) {
    problem.model[static_cast<size_t>(i)] = ModelVertex(family, i);
  }
  const Homography normalized = ToNormalized(map, camera);
  Matrix3d rotations[2];
  if (!PlanarRotations(normalized, rotations)) return false;
  Rigid solution[2];
  double cost[2];
  for (int k = 0; k < 2; ++k) {
    solution[k] = {rotations[k], SolveTranslation(problem, normalized, rotations[k])};
    cost[k] = Refine(problem, &solution[k]);
  }
  const int best = cost[0] <= cost[1] ? 0 : 1;
  const int other = 1 - best;
  if (!std::isfinite(cost[best])) return false;

  const double unit = tag_size / family.white_side();
  static_cast<PoseSolution&>(*pose) = ToSolution(problem, solution[best], unit);
  pose->covariance = Covariance(problem, solution[best], unit);
  pose->alternative.reset();
  const double angle = Eigen::AngleAxisd(solution[best].R.transpose() * solution[other].R).angle();
  if (std::isfinite(cost[other]) && angle > kSameRotation) {
    pose->alternative = ToSolution(problem, solution[other], unit);
  }
  return true;
}

}  // namespace topotag
