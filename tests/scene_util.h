#ifndef TOPOTAG_TESTS_SCENE_UTIL_H_
#define TOPOTAG_TESTS_SCENE_UTIL_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "topotag/renderer.h"

namespace topotag::test {

constexpr double kDegree = M_PI / 180;

inline Matrix3 operator*(const Matrix3& a, const Matrix3& b) {
  Matrix3 c{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

inline Matrix3 RotationX(double a) {
  return {{{1, 0, 0}, {0, std::cos(a), -std::sin(a)}, {0, std::sin(a), std::cos(a)}}};
}

inline Matrix3 RotationZ(double a) {
  return {{{std::cos(a), -std::sin(a), 0}, {std::sin(a), std::cos(a), 0}, {0, 0, 1}}};
}

/// A camera without distortion whose optical axis meets the centre of the frame.
inline Camera PinholeCamera(int width, int height, double focal_length) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal_length;
  camera.cx = (width - 1) / 2.0;
  camera.cy = (height - 1) / 2.0;
  return camera;
}

/// Distance at which the pitch of the nodes is `pitch` pixels, metres.
inline double DistanceForPitch(const Camera& camera, Family family, double tag_size, double pitch) {
  return camera.fx * 4 * tag_size / family.white_side() / pitch;
}

/// The same numbers on every platform.
class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  double Uniform(double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  uint64_t Below(uint64_t n) { return engine_() % n; }
  /// Of variance 1 (Box-Muller, one of the two values).
  double Gaussian() {
    const double radius = std::sqrt(-2 * std::log(1 - Uniform(0, 1)));
    return radius * std::cos(2 * M_PI * Uniform(0, 1));
  }

  /// Turned at random in its plane and about the optical axis, tilted by `tilt` radians.
  Matrix3 Tilted(double tilt) {
    const Matrix3 roll = RotationZ(Uniform(0, 2 * M_PI));
    return roll * (RotationX(tilt) * RotationZ(Uniform(0, 2 * M_PI)));
  }

 private:
  std::mt19937_64 engine_;
};

/// Angle of the rotation between two rotations, degrees.
inline double AngleBetween(const Matrix3& a, const Matrix3& b) {
  // Of the difference, which keeps its digits at small angles.
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) sum += (a[i][j] - b[i][j]) * (a[i][j] - b[i][j]);
  }
  return 2 * std::asin(std::min(std::sqrt(sum / 8), 1.0)) / kDegree;
}

inline double Norm(const Vector3& v) { return std::hypot(v[0], v[1], v[2]); }

inline double Distance(const Vector3& a, const Vector3& b) {
  return Norm({a[0] - b[0], a[1] - b[1], a[2] - b[2]});
}

inline double Distance(const Point2& a, const Point2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

}  // namespace topotag::test

#endif  // TOPOTAG_TESTS_SCENE_UTIL_H_
