#include "host/rotation.h"

#include <cmath>

namespace topotag {

Matrix3 Exp(const Vector3& w) {
  const double angle = std::hypot(w[0], w[1], w[2]);
  // sin(a)/a and (1-cos(a))/a^2, by their limits where a is too small to divide by.
  const double s = angle < 1e-8 ? 1 : std::sin(angle) / angle, half = std::sin(angle / 2);
  const double c = angle < 1e-8 ? 0.5 : 2 * half * half / (angle * angle);
  const double x = w[0], y = w[1], z = w[2];
  return {{{1 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y},
           {c * x * y + s * z, 1 - c * (x * x + z * z), c * y * z - s * x},
           {c * x * z - s * y, c * y * z + s * x, 1 - c * (x * x + y * y)}}};
}

Matrix3 Transposed(const Matrix3& r) {
  Matrix3 t{};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) t[i][j] = r[j][i];
  }
  return t;
}

}  // namespace topotag
