#include "host/homography.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace topotag {
namespace {

// Similarity that takes points to mean 0 and mean absolute deviation about 1, which keeps the
// normal equations well conditioned.
struct Normalization {
  double cx, cy, scale;
  Point2 Apply(Point2 p) const { return {(p.x - cx) * scale, (p.y - cy) * scale}; }
};

Normalization Normalize(const Point2* points, int n) {
  double cx = 0;
  double cy = 0;
  for (int i = 0; i < n; ++i) {
    cx += points[i].x;
    cy += points[i].y;
  }
  cx /= n;
  cy /= n;
  double spread = 0;
  for (int i = 0; i < n; ++i) spread += std::abs(points[i].x - cx) + std::abs(points[i].y - cy);
  return {cx, cy, spread > 0 ? 2 * n / spread : 1};
}

using Vector8 = Eigen::Matrix<double, 8, 1>;
using Matrix8 = Eigen::Matrix<double, 8, 8>;

// One linear solution for h of (h0 x + h1 y + h2) - u (h6 x + h7 y + 1) = 0 and the same with v,
// each equation weighted by 1 / denominator^2 of the previous solution: after the second
// round the residuals are distances.
bool SolveLinear(const Point2* from, const Point2* to, int n, Vector8* h) {
  Matrix8 normal = Matrix8::Zero();
  Vector8 right = Vector8::Zero();
  for (int i = 0; i < n; ++i) {
    const double x = from[i].x;
    const double y = from[i].y;
    const double denominator = (*h)[6] * x + (*h)[7] * y + 1;
    const double w = 1 / (denominator * denominator);
    const double a[3] = {x, y, 1};
    const double uv[2] = {to[i].x, to[i].y};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c) {
        const double product = w * a[r] * a[c];
        normal(r, c) += product;
        normal(3 + r, 3 + c) += product;
        if (r < 2) normal(6 + r, 6 + c) += product * (uv[0] * uv[0] + uv[1] * uv[1]);
      }
      for (int k = 0; k < 2; ++k) {
        const double product = w * a[r] * uv[k];
        right(3 * k + r) += product;
        for (int c = 0; c < 2; ++c) normal(6 + c, 3 * k + r) -= product * a[c];
      }
      if (r < 2) right(6 + r) -= w * a[r] * (uv[0] * uv[0] + uv[1] * uv[1]);
    }
  }
  const Eigen::LDLT<Matrix8> solver(normal);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-12)) return false;
  *h = solver.solve(right);
  return h->allFinite();
}

}  // namespace

Point2 Homography::Map(Point2 p) const {
  const double w = 1 / Denominator(p);
  return {(m[0][0] * p.x + m[0][1] * p.y + m[0][2]) * w,
          (m[1][0] * p.x + m[1][1] * p.y + m[1][2]) * w};
}

Point2 Homography::Map(Point2 p, Jacobian2* jacobian) const {
  const double w = 1 / Denominator(p);
  const Point2 q = Map(p);
  *jacobian = {(m[0][0] - q.x * m[2][0]) * w, (m[0][1] - q.x * m[2][1]) * w,
               (m[1][0] - q.y * m[2][0]) * w, (m[1][1] - q.y * m[2][1]) * w};
  return q;
}

bool FitHomography(const Point2* from, const Point2* to, int n, Homography* homography) {
  constexpr int kMaxPoints = 64;
  Point2 a[kMaxPoints];
  Point2 b[kMaxPoints];
  n = std::min(n, kMaxPoints);
  const Normalization na = Normalize(from, n);
  const Normalization nb = Normalize(to, n);
  for (int i = 0; i < n; ++i) {
    a[i] = na.Apply(from[i]);
    b[i] = nb.Apply(to[i]);
  }
  Vector8 h = Vector8::Zero();
  const int rounds = n == 4 ? 1 : 2;  // four points are met exactly, whatever the weights
  for (int round = 0; round < rounds; ++round) {
    if (!SolveLinear(a, b, n, &h)) return false;
    for (int i = 0; i < n; ++i) {
      if (!(h[6] * a[i].x + h[7] * a[i].y + 1 > 1e-6)) return false;
    }
  }
  // Undo the normalisations: H = Nb^-1 H' Na.
  double rows[3][3];
  const double hh[3][3] = {{h[0], h[1], h[2]}, {h[3], h[4], h[5]}, {h[6], h[7], 1}};
  for (int r = 0; r < 3; ++r) {
    rows[r][0] = hh[r][0] * na.scale;
    rows[r][1] = hh[r][1] * na.scale;
    rows[r][2] = hh[r][2] - rows[r][0] * na.cx - rows[r][1] * na.cy;
  }
  if (!(rows[2][2] > 0)) return false;
  for (int c = 0; c < 3; ++c) {
    homography->m[0][c] = (rows[0][c] / nb.scale + nb.cx * rows[2][c]) / rows[2][2];
    homography->m[1][c] = (rows[1][c] / nb.scale + nb.cy * rows[2][c]) / rows[2][2];
    homography->m[2][c] = rows[2][c] / rows[2][2];
  }
  return true;
}

bool Invert(const Homography& homography, Homography* inverse) {
  const Matrix3& m = homography.m;
  Matrix3 adjugate;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const int r1 = (c + 1) % 3, r2 = (c + 2) % 3, c1 = (r + 1) % 3, c2 = (r + 2) % 3;
      adjugate[r][c] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
    }
  }
  const double scale = adjugate[2][2];
  if (!(std::abs(scale) > 0)) return false;
  for (auto& row : adjugate) {
    for (double& value : row) value /= scale;
  }
  inverse->m = adjugate;
  return true;
}

Point2 TagMap::Pixel(Point2 tag, Jacobian2* jacobian) const {
  if (!HasLens()) {
    return jacobian ? ideal.Map(tag, jacobian) : ideal.Map(tag);
  }
  Jacobian2 outer;
  Jacobian2 inner;
  const Point2 p = ideal.Map(tag, &inner);
  const Point2 pixel =
      Project(*camera, {(p.x - camera->cx) / camera->fx, (p.y - camera->cy) / camera->fy}, &outer);
  if (jacobian != nullptr) {
    for (int r = 0; r < 2; ++r) {
      for (int c = 0; c < 2; ++c) {
        (*jacobian)[2 * r + c] =
            outer[2 * r] / camera->fx * inner[c] + outer[2 * r + 1] / camera->fy * inner[2 + c];
      }
    }
  }
  return pixel;
}

bool PixelToIdeal(const Camera* camera, Point2 pixel, Point2* ideal) {
  if (camera == nullptr || camera->model == DistortionModel::kNone) {
    *ideal = pixel;
    return true;
  }
  Point2 normalized;
  if (!Unproject(*camera, pixel, &normalized)) return false;
  *ideal = {camera->fx * normalized.x + camera->cx, camera->fy * normalized.y + camera->cy};
  return true;
}

}  // namespace topotag
