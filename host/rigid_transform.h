#ifndef TOPOTAG_HOST_RIGID_TRANSFORM_H_
#define TOPOTAG_HOST_RIGID_TRANSFORM_H_

#include <cstddef>

#include "host/rotation.h"
#include "topotag/geometry.h"

namespace topotag {

inline constexpr Matrix3 kIdentity3{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

inline Vector3 operator*(const Matrix3& m, const Vector3& v) {
  Vector3 result;
  for (std::size_t i = 0; i < 3; ++i) result[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return result;
}

inline Matrix3 operator*(const Matrix3& a, const Matrix3& b) {
  Matrix3 result;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      result[i][k] = a[i][0] * b[0][k] + a[i][1] * b[1][k] + a[i][2] * b[2][k];
    }
  }
  return result;
}

inline Vector3 operator+(const Vector3& a, const Vector3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

inline Vector3 operator-(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// x -> R x + t.
struct RigidTransform {
  Matrix3 R = kIdentity3;
  Vector3 t{};

  Vector3 operator*(const Vector3& x) const { return R * x + t; }
  RigidTransform operator*(const RigidTransform& other) const {
    return {R * other.R, *this * other.t};
  }
  RigidTransform Inverse() const {
    const Matrix3 inverse = Transposed(R);
    const Vector3 moved = inverse * t;
    return {inverse, {-moved[0], -moved[1], -moved[2]}};
  }
};

/// Rotation vector of any rotation, also of half a turn; its length is at most pi.
Vector3 RotationVector(const Matrix3& rotation);

/// Rotation of the quaternion (1, w / 2): exp(w) to second order, without a sine.
Matrix3 SmallRotation(const Vector3& w);

/// The rotation near to a matrix that rounding has moved away from one.
Matrix3 Orthonormalized(const Matrix3& m);

/// R R' = 1 to 1e-6, and not a mirror image.
bool IsRotation(const Matrix3& m);

/// Angle of the rotation between two rotations, radians.
double RotationBetween(const Matrix3& a, const Matrix3& b);

}  // namespace topotag

#endif  // TOPOTAG_HOST_RIGID_TRANSFORM_H_
