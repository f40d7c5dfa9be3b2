#include "host/rigid_transform.h"

#include <algorithm>
#include <cmath>

#include "host/planar_pose.h"

namespace topotag {
namespace {

constexpr double kRotationTolerance = 1e-6;

}  // namespace

Vector3 RotationVector(const Matrix3& r) {
  // The unit quaternion (s, q), from its largest element, so that no difference loses digits.
  const std::array<double, 4> squares{1 + r[0][0] + r[1][1] + r[2][2],   //
                                      1 + r[0][0] - r[1][1] - r[2][2],   //
                                      1 - r[0][0] + r[1][1] - r[2][2],   //
                                      1 - r[0][0] - r[1][1] + r[2][2]};  // 4 of each element's
  const size_t k =
      static_cast<size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());
  double s;
  Vector3 q;
  if (k == 0) {
    s = squares[0];
    q = {r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]};
  } else {
    const size_t i = k - 1, j = k % 3, m = (k + 1) % 3;
    s = r[m][j] - r[j][m];
    q[i] = squares[k];
    q[j] = r[i][j] + r[j][i];
    q[m] = r[i][m] + r[m][i];
  }
  const double length = std::sqrt(Dot(q, q));
  if (length == 0) return {};
  // |angle| <= pi: the quaternion with a scalar that is not negative.
  const double angle = 2 * std::atan2(length, std::abs(s));
  return Scaled(q, (s < 0 ? -angle : angle) / length);
}

Matrix3 SmallRotation(const Vector3& w) {
  const Vector3 h = Scaled(w, 0.5);
  const double scale = 2 / (1 + Dot(h, h));
  const auto [x, y, z] = h;
  return {{{1 - scale * (y * y + z * z), scale * (x * y - z), scale * (x * z + y)},
           {scale * (x * y + z), 1 - scale * (x * x + z * z), scale * (y * z - x)},
           {scale * (x * z - y), scale * (y * z + x), 1 - scale * (x * x + y * y)}}};
}

Matrix3 Orthonormalized(const Matrix3& m) {
  Rigid axes{m[0], m[1], {}};
  Orthonormalize(&axes);
  return {axes.x, axes.y, Cross(axes.x, axes.y)};
}

bool IsRotation(const Matrix3& m) {
  for (size_t i = 0; i < 3; ++i) {
    for (size_t k = 0; k <= i; ++k) {
      // Written so that NaN fails too.
      if (!(std::abs(Dot(m[i], m[k]) - (i == k ? 1 : 0)) < kRotationTolerance)) return false;
    }
  }
  return Dot(Cross(m[0], m[1]), m[2]) > 0;
}

double RotationBetween(const Matrix3& a, const Matrix3& b) {
  // Of the difference, which keeps its digits at small angles.
  double sum = 0;
  for (size_t i = 0; i < 3; ++i) {
    const Vector3 d = a[i] - b[i];
    sum += Dot(d, d);
  }
  return 2 * std::asin(std::min(std::sqrt(sum / 8), 1.0));
}

}  // namespace topotag
