#ifndef TOPOTAG_TESTS_RENDERER_TEST_UTIL_H_
#define TOPOTAG_TESTS_RENDERER_TEST_UTIL_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "topotag/renderer.h"

namespace topotag {

inline constexpr double kBackground = 90, kBlack = 25, kWhite = 215;

// About an axis of any length, radians.
inline Matrix3 Rotation(Vector3 axis, double angle) {
  const double norm = std::hypot(axis[0], axis[1], axis[2]);
  const double x = axis[0] / norm, y = axis[1] / norm, z = axis[2] / norm;
  const double c = std::cos(angle), s = std::sin(angle), k = 1 - c;
  return {{{c + x * x * k, x * y * k - z * s, x * z * k + y * s},
           {y * x * k + z * s, c + y * y * k, y * z * k - x * s},
           {z * x * k - y * s, z * y * k + x * s, c + z * z * k}}};
}

// One fronto-parallel marker, `pitch` pixels a unit, its origin at (x, y). No noise.
inline Scene FrontalScene(int width, int height, double x, double y, double pitch) {
  Scene scene;
  scene.camera.width = width;
  scene.camera.height = height;
  scene.camera.fx = scene.camera.fy = 600;
  scene.camera.cx = x;
  scene.camera.cy = y;
  scene.noise = 0;
  SceneMarker marker;
  marker.design.id = 8390;
  marker.t = {0, 0, 600 / pitch * marker.tag_size / marker.design.family.white_side()};
  scene.markers.push_back(marker);
  return scene;
}

// The pixel nearest to a point.
inline int At(const Image& image, double x, double y) {
  return image.row(static_cast<int>(std::lround(y)))[static_cast<int>(std::lround(x))];
}

// Largest difference, and the number of pixels that differ at all.
struct Difference {
  int largest = 0;
  int count = 0;
};
template <typename Other>
Difference Compare(const Image& a, const Other& b) {
  Difference difference;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      const int d = std::abs(a.row(y)[x] - b(x, y));
      difference.largest = std::max(difference.largest, d);
      difference.count += d != 0;
    }
  }
  return difference;
}

// Rounding to whole grey levels turns an error of 1e-3 into one level in a few pixels only.
inline void ExpectSame(const Difference& difference) {
  EXPECT_LE(difference.largest, 1);
  EXPECT_LE(difference.count, 3);
}

}  // namespace topotag

#endif  // TOPOTAG_TESTS_RENDERER_TEST_UTIL_H_
