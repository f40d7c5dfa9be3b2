// Lens models: distortion, its derivatives and its inverse, for points.
//
// Formulas are those of OpenCV's calib3d documentation. OpenCV inverts them by a fixed-point
// iteration that does not converge for strong lenses and never says so; here it is a Newton
// iteration whose result is accepted only where the lens model is provably one-to-one.
#include "topotag/camera.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "host/check.h"

namespace topotag {
namespace {

constexpr double kHalfPi = 1.57079632679489661923;
// Beyond any camera, and such that no pose's covariance leaves the range of a double.
constexpr double kMinFocalLength = 1e-9;
constexpr double kMaxCoordinate = 1e9;
// Below this radius the fisheye model is the identity to double precision.
constexpr double kTinyRadius = 1e-8;
// See Converged.
constexpr double kConvergedStep = 1e-8;
constexpr double kSmallStep = 3e-6;
constexpr double kTolerance = 1e-12;
constexpr int kMaxEvaluations = 40;
constexpr int kContinuationSteps = 16;
constexpr int kMaxSubdivisions = 10;

double SquaredNorm(Point2 p) { return p.x * p.x + p.y * p.y; }

// True if the polynomial of degree N with these Bernstein coefficients over an interval is
// proven positive on it. Bisects the interval (de Casteljau) while the coefficients are of both
// signs; a minimum too close to zero to be told from zero counts as not positive.
template <int N>
bool BernsteinPositive(std::array<double, N + 1> b, int subdivisions) {
  if (!(b[0] > 0) || !(b[N] > 0)) return false;
  if (*std::min_element(b.begin(), b.end()) > 0) return true;
  if (subdivisions == 0) return false;
  std::array<double, N + 1> left;
  for (int level = 0; level <= N; ++level) {
    left[level] = b[0];
    for (int i = 0; i < N - level; ++i) b[i] = 0.5 * (b[i] + b[i + 1]);
  }
  // The loop leaves in b the coefficients of the right half.
  return BernsteinPositive<N>(left, subdivisions - 1) && BernsteinPositive<N>(b, subdivisions - 1);
}

// True if sum c[i] s^i is proven positive for 0 <= s <= 1.
template <int N>
bool PositiveOnUnit(std::array<double, N + 1> c) {
  double lower = c[0];
  for (int i = 1; i <= N; ++i) lower += std::min(c[i], 0.0);
  if (lower > 0) return true;
  double binomial = 1;
  for (int i = 1; i <= N; ++i) {
    binomial = binomial * (N + 1 - i) / i;
    c[i] /= binomial;
  }
  for (int level = 1; level <= N; ++level) {
    for (int i = N; i >= level; --i) c[i] += c[i - 1];
  }
  return BernsteinPositive<N>(c, kMaxSubdivisions);
}

// True if a Newton iteration is done after this step. The error of one step is the previous one
// squared times a constant, which two steps reveal, so that no evaluation is spent on confirming.
bool Converged(double squared_step, double squared_previous) {
  return squared_step <= kConvergedStep * kConvergedStep ||
         (squared_step <= kSmallStep * kSmallStep &&
          squared_step * squared_step * squared_step <=
              kTolerance * kTolerance * squared_previous * squared_previous);
}

// Solves a lens equation on the branch that starts at the centre: directly, and where that fails
// or leads elsewhere, along the scaled targets s * target, s = 0 .. 1.
// solve(s, start, result) is a local solver, accept(result) proves the branch.
template <typename T, typename Solve, typename Accept>
bool SolveConnected(const T& guess, const Solve& solve, const Accept& accept, T* result) {
  if (solve(1.0, guess, result) && accept(*result)) return true;
  T current{};
  for (int i = 1; i <= kContinuationSteps; ++i) {
    if (!solve(static_cast<double>(i) / kContinuationSteps, current, &current)) return false;
  }
  *result = current;
  return accept(current);
}

// --- Brown: radial (rational), tangential, thin prism; the tilt is separate --------------------

// Value and derivatives in plain scalars, which stay in registers where an array would not.
struct Distorted {
  double x, y;
  double xx, xy, yx, yy;  // dx'/dx, dx'/dy, dy'/dx, dy'/dy
};

// The Brown model times powers of its rational polynomial's denominator D, so that an iteration
// waits for one division, not for two in a row.
struct ScaledDistorted {
  double denominator;     // D; not positive beyond a pole
  double x, y;            // D x', D y'
  double xx, xy, yx, yy;  // D^2 dx'/dx ..
};

[[gnu::always_inline]] inline ScaledDistorted BrownDistort(const double* d, double x, double y) {
  const double k1 = d[0], k2 = d[1], p1 = d[2], p2 = d[3], k3 = d[4], k4 = d[5], k5 = d[6];
  const double k6 = d[7], s1 = d[8], s2 = d[9], s3 = d[10], s4 = d[11];
  const double xx = x * x, yy = y * y, xy = x * y, u = xx + yy, u2 = u * u;
  const double n = (1 + u * k1) + u2 * (k2 + u * k3);
  const double m = (1 + u * k4) + u2 * (k5 + u * k6);
  const double dn = k1 + 2 * u * k2 + 3 * u2 * k3, dm = k4 + 2 * u * k5 + 3 * u2 * k6;
  const double radial = n * m, slope = 2 * (dn * m - n * dm), mm = m * m;
  const double sx = 2 * (s1 + 2 * u * s2), sy = 2 * (s3 + 2 * u * s4);
  const double mixed = 2 * (p1 * x + p2 * y);
  return {m,
          x * n + m * (2 * p1 * xy + p2 * (u + 2 * xx) + (u * s1 + u2 * s2)),
          y * n + m * (2 * p2 * xy + p1 * (u + 2 * yy) + (u * s3 + u2 * s4)),
          radial + slope * xx + mm * (2 * p1 * y + 6 * p2 * x + sx * x),
          slope * xy + mm * (mixed + sx * y),
          slope * xy + mm * (mixed + sy * x),
          radial + slope * yy + mm * (6 * p1 * y + 2 * p2 * x + sy * y)};
}

// Damped Newton iteration; every iterate keeps to where the map preserves orientation. `start` is
// taken as a first step from the centre, and so is damped as well.
bool BrownSolve(const double* d, Point2 target, Point2 start, Point2* result) {
  double x = 0, y = 0, step_x = start.x, step_y = start.y;
  double norm = SquaredNorm(target), previous = 0;
  for (int i = 0; i < kMaxEvaluations; ++i) {
    const ScaledDistorted q = BrownDistort(d, x + step_x, y + step_y);
    const double m = q.denominator, mm = m * m;
    const double residual_x = target.x * m - q.x, residual_y = target.y * m - q.y;
    const double residual = residual_x * residual_x + residual_y * residual_y;
    const double determinant = q.xx * q.yy - q.xy * q.yx;
    if (!(m > 0) || !(determinant > 0) || !(residual <= norm * mm)) {
      step_x *= 0.5;
      step_y *= 0.5;
      previous = 0;
      continue;
    }
    x += step_x;
    y += step_y;
    const double scale = m / determinant;
    step_x = (q.yy * residual_x - q.xy * residual_y) * scale;
    step_y = (q.xx * residual_y - q.yx * residual_x) * scale;
    const double squared = step_x * step_x + step_y * step_y;
    if (Converged(squared, previous)) {
      *result = {x + step_x, y + step_y};
      return true;
    }
    norm = residual / mm;
    previous = squared;
  }
  return false;
}

// True if the model is proven one-to-one on the disc through p. With r^2 = u and radial map
// f(r) = r N(u) / D(u), the Jacobian is a symmetric matrix with eigenvalues f' and f / r, plus the
// tangential and prism terms, whose norm on the disc is at most `other`. Where f' > other, the
// Jacobian's symmetric part is positive definite, and on a convex set that implies one-to-one.
bool BrownInvertibleTo(const double* d, Point2 p) {
  const double u = SquaredNorm(p), u2 = u * u, u3 = u2 * u;
  const double n1 = d[0] * u, n2 = d[1] * u2, n3 = d[4] * u3;
  const double m1 = d[5] * u, m2 = d[6] * u2, m3 = d[7] * u3;
  const double prism =
      std::abs(d[8]) + std::abs(d[10]) + 2 * u * (std::abs(d[9]) + std::abs(d[11]));
  const double other = (6 * (std::abs(d[2]) + std::abs(d[3])) + 2 * prism) * std::sqrt(u);
  // (f' - other) D^2 as a polynomial in the fraction of u.
  const std::array<double, 7> slope{
      1 - other,
      3 * n1 - m1 - 2 * other * m1,
      5 * n2 + n1 * m1 - 3 * m2 - other * (2 * m2 + m1 * m1),
      7 * n3 + 3 * n2 * m1 - n1 * m2 - 5 * m3 - 2 * other * (m3 + m1 * m2),
      5 * n3 * m1 + n2 * m2 - 3 * n1 * m3 - other * (2 * m1 * m3 + m2 * m2),
      3 * n3 * m2 - n2 * m3 - 2 * other * m2 * m3,
      n3 * m3 - other * m3 * m3};
  return PositiveOnUnit<3>({1, m1, m2, m3}) && PositiveOnUnit<6>(slope);
}

// Nearly undoes the radial part: one Newton step on s N(s^2 v) = D(s^2 v), v = |target|^2, from
// s = 1, at a fraction of the cost of a step in the plane.
Point2 BrownGuess(const double* d, Point2 target) {
  const double v = SquaredNorm(target), v2 = v * v, v3 = v2 * v;
  const double n1 = d[0] * v, n2 = d[1] * v2, n3 = d[4] * v3;
  const double m1 = d[5] * v, m2 = d[6] * v2, m3 = d[7] * v3;
  const double n = 1 + n1 + n2 + n3, m = 1 + m1 + m2 + m3;
  const double slope = n + 2 * ((n1 - m1) + 2 * (n2 - m2) + 3 * (n3 - m3));
  const double s = 1 - (n - m) / slope;
  if (!(s > 0)) return target;
  return {s * target.x, s * target.y};
}

bool BrownUndistort(const double* d, Point2 target, Point2* result) {
  return SolveConnected(
      BrownGuess(d, target),
      [&](double s, Point2 start, Point2* p) {
        return BrownSolve(d, {s * target.x, s * target.y}, start, p);
      },
      [&](Point2 p) { return BrownInvertibleTo(d, p); }, result);
}

Distorted BrownProject(const double* d, Point2 p) {
  const ScaledDistorted q = BrownDistort(d, p.x, p.y);
  const double inverse = 1 / q.denominator, inverse2 = inverse * inverse;
  return {q.x * inverse,   q.y * inverse,   q.xx * inverse2,
          q.xy * inverse2, q.yx * inverse2, q.yy * inverse2};
}

// --- Tilt of the sensor: a homography between the distorted plane and the sensor ----------------

// The rotation R(tau_x, tau_y), row-major.
std::array<double, 9> TiltRotation(double tau_x, double tau_y) {
  const double sx = std::sin(tau_x), cx = std::cos(tau_x);
  const double sy = std::sin(tau_y), cy = std::cos(tau_y);
  return {cy, sy * sx, -sy * cx, 0, cx, sx, sy, -cy * sx, cy * cx};
}

Distorted Tilt(const double* tau, const Distorted& p) {
  const auto r = TiltRotation(tau[0], tau[1]);
  const double wx = r[0] * p.x + r[1] * p.y + r[2];
  const double wy = r[3] * p.x + r[4] * p.y + r[5];
  const double inverse = 1 / (r[6] * p.x + r[7] * p.y + r[8]);
  const double ux = wx * inverse, uy = wy * inverse, scale = r[8] * inverse;
  const double txx = (r[0] - ux * r[6]) * scale, txy = (r[1] - ux * r[7]) * scale;
  const double tyx = (r[3] - uy * r[6]) * scale, tyy = (r[4] - uy * r[7]) * scale;
  return {r[8] * ux - r[2],        r[8] * uy - r[5],        txx * p.xx + txy * p.yx,
          txx * p.xy + txy * p.yy, tyx * p.xx + tyy * p.yx, tyx * p.xy + tyy * p.yy};
}

// Returns false behind the tilted sensor's horizon.
bool Untilt(const double* tau, Point2 q, Point2* p) {
  const auto r = TiltRotation(tau[0], tau[1]);
  if (!(r[8] > 0)) return false;
  const double wx = (q.x + r[2]) / r[8], wy = (q.y + r[5]) / r[8];
  const double w = r[2] * wx + r[5] * wy + r[8];
  *p = {(r[0] * wx + r[3] * wy + r[6]) / w, (r[1] * wx + r[4] * wy + r[7]) / w};
  return w > 0;
}

// --- Fisheye (equidistant) ---------------------------------------------------------------------

double FisheyeAngle(const double* k, double theta, double* derivative) {
  const double v = theta * theta;
  *derivative = 1 + v * (3 * k[0] + v * (5 * k[1] + v * (7 * k[2] + v * 9 * k[3])));
  return theta * (1 + v * (k[0] + v * (k[1] + v * (k[2] + v * k[3]))));
}

Distorted FisheyeDistort(const double* k, double x, double y) {
  const double u = x * x + y * y, r = std::sqrt(u);
  if (r <= kTinyRadius) return {x, y, 1, 0, 0, 1};
  double derivative;
  const double s = FisheyeAngle(k, std::atan(r), &derivative) / r;
  const double radial = (derivative / (1 + u) - s) / u;
  const double mixed = radial * x * y;
  return {x * s, y * s, s + radial * x * x, mixed, mixed, s + radial * y * y};
}

// Damped Newton iteration that keeps to angles at which the model increases; as BrownSolve.
bool FisheyeSolve(const double* k, double target, double start, double* result) {
  double theta = 0, step = start, norm = target, previous = 0;
  for (int i = 0; i < kMaxEvaluations; ++i) {
    double slope;
    const double residual = target - FisheyeAngle(k, theta + step, &slope);
    if (!(slope > 0) || !(std::abs(residual) <= norm)) {
      step *= 0.5;
      previous = 0;
      continue;
    }
    theta += step;
    norm = std::abs(residual);
    step = residual / slope;
    if (Converged(step * step, previous)) {
      *result = theta + step;
      return true;
    }
    previous = step * step;
  }
  return false;
}

bool FisheyeInvertibleTo(const double* k, double theta) {
  if (!(std::abs(theta) < kHalfPi)) return false;
  const double v = theta * theta;
  return PositiveOnUnit<4>(
      {1, 3 * k[0] * v, 5 * k[1] * v * v, 7 * k[2] * v * v * v, 9 * k[3] * v * v * v * v});
}

bool FisheyeUndistort(const double* k, Point2 target, Point2* result) {
  const double radius = std::sqrt(SquaredNorm(target));
  if (radius <= kTinyRadius) {
    *result = target;
    return true;
  }
  double theta;
  const bool solved = SolveConnected(
      std::min(radius, kHalfPi),
      [&](double s, double start, double* t) { return FisheyeSolve(k, s * radius, start, t); },
      [&](double t) { return FisheyeInvertibleTo(k, t); }, &theta);
  if (!solved) return false;
  const double s = std::tan(theta) / radius;
  *result = {target.x * s, target.y * s};
  return true;
}

void Require(bool condition, const char* field, double value, const char* reason) {
  if (condition) return;
  FailArgument(std::string("camera: ") + field + " " + Text(value) + " " + reason);
}

}  // namespace

void ValidateCamera(const Camera& camera) {
  static constexpr const char* kFinite = "is not finite";
  RequireEnum("camera: model", camera.model, DistortionModel::kFisheye);
  RequireRange("camera: fx", camera.fx, kMinFocalLength, kMaxCoordinate, "pixels");
  RequireRange("camera: fy", camera.fy, kMinFocalLength, kMaxCoordinate, "pixels");
  RequireRange("camera: cx", camera.cx, -kMaxCoordinate, kMaxCoordinate, "pixels");
  RequireRange("camera: cy", camera.cy, -kMaxCoordinate, kMaxCoordinate, "pixels");
  Require(camera.width >= 0, "width", camera.width, "is negative");
  Require(camera.height >= 0, "height", camera.height, "is negative");
  if ((camera.width == 0) != (camera.height == 0)) {
    FailArgument("camera: size " + Text(camera.width, camera.height) +
                 " has only one of width and height");
  }
  for (size_t i = 0; i < camera.distortion.size(); ++i) {
    const std::string field = "distortion[" + std::to_string(i) + "]";
    Require(std::isfinite(camera.distortion[i]), field.c_str(), camera.distortion[i], kFinite);
  }
}

Point2 Project(const Camera& camera, Point2 normalized, Jacobian2* jacobian) {
  const double* d = camera.distortion.data();
  Distorted q{normalized.x, normalized.y, 1, 0, 0, 1};
  if (camera.model == DistortionModel::kBrown) {
    q = BrownProject(d, normalized);
    if (d[12] != 0 || d[13] != 0) q = Tilt(d + 12, q);
  } else if (camera.model == DistortionModel::kFisheye) {
    q = FisheyeDistort(d, normalized.x, normalized.y);
  }
  if (jacobian != nullptr) {
    *jacobian = {camera.fx * q.xx, camera.fx * q.xy, camera.fy * q.yx, camera.fy * q.yy};
  }
  return {camera.fx * q.x + camera.cx, camera.fy * q.y + camera.cy};
}

bool Unproject(const Camera& camera, Point2 pixel, Point2* normalized) {
  const double* d = camera.distortion.data();
  Point2 q{(pixel.x - camera.cx) / camera.fx, (pixel.y - camera.cy) / camera.fy};
  if (!std::isfinite(q.x) || !std::isfinite(q.y)) return false;
  Point2 p = q;
  switch (camera.model) {
    case DistortionModel::kNone:
      break;
    case DistortionModel::kBrown:
      if ((d[12] != 0 || d[13] != 0) && !Untilt(d + 12, q, &q)) return false;
      if (!BrownUndistort(d, q, &p)) return false;
      break;
    case DistortionModel::kFisheye:
      if (!FisheyeUndistort(d, q, &p)) return false;
      break;
  }
  if (!std::isfinite(p.x) || !std::isfinite(p.y)) return false;
  *normalized = p;
  return true;
}

}  // namespace topotag
