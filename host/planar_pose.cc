#include "host/planar_pose.h"

#include <algorithm>
#include <cmath>

namespace topotag {

void Orthonormalize(Rigid* pose) {
  pose->x = Scaled(pose->x, 1 / std::sqrt(Dot(pose->x, pose->x)));
  const double along = Dot(pose->x, pose->y);
  for (size_t i = 0; i < 3; ++i) pose->y[i] -= along * pose->x[i];
  pose->y = Scaled(pose->y, 1 / std::sqrt(Dot(pose->y, pose->y)));
}

bool PlanarPoses(const Homography& normalized, Rigid poses[2]) {
  Jacobian2 j;
  const Point2 v = normalized.Map({0, 0}, &j);
  // Rotation Rv that takes the z axis to the ray of the origin, about an axis in the image plane.
  const double length = std::sqrt(v.x * v.x + v.y * v.y + 1);
  const Vector3 ray{v.x / length, v.y / length, 1 / length};
  const double k = 1 / (1 + ray[2]);
  const Matrix3 rv{{{1 - ray[0] * ray[0] * k, -ray[0] * ray[1] * k, ray[0]},
                    {-ray[0] * ray[1] * k, 1 - ray[1] * ray[1] * k, ray[1]},
                    {-ray[0], -ray[1], ray[2]}}};
  // A = B^-1 J, B the image of the rotated plane's axes. Its larger singular value is 1 / depth.
  const double b00 = rv[0][0] - v.x * rv[2][0], b01 = rv[0][1] - v.x * rv[2][1];
  const double b10 = rv[1][0] - v.y * rv[2][0], b11 = rv[1][1] - v.y * rv[2][1];
  const double inverse = 1 / (b00 * b11 - b01 * b10);
  const double a00 = (b11 * j[0] - b01 * j[2]) * inverse, a01 = (b11 * j[1] - b01 * j[3]) * inverse;
  const double a10 = (b00 * j[2] - b10 * j[0]) * inverse, a11 = (b00 * j[3] - b10 * j[1]) * inverse;
  const double trace = a00 * a00 + a01 * a01 + a10 * a10 + a11 * a11;
  const double det = a00 * a11 - a01 * a10;
  const double gamma =
      std::sqrt((trace + std::sqrt(std::max(trace * trace - 4 * det * det, 0.0))) / 2);
  if (!(gamma > 0) || !std::isfinite(gamma)) return false;
  const double depth = 1 / gamma;
  const double r00 = a00 * depth, r01 = a01 * depth, r10 = a10 * depth, r11 = a11 * depth;
  const double c0 = std::sqrt(std::max(1 - r00 * r00 - r10 * r10, 0.0));
  const double c1 =
      std::copysign(std::sqrt(std::max(1 - r01 * r01 - r11 * r11, 0.0)), -(r00 * r01 + r10 * r11));
  for (int s = 0; s < 2; ++s) {
    const double sign = s == 0 ? 1 : -1;
    const Vector3 x{r00, r10, sign * c0};
    const Vector3 y{r01, r11, sign * c1};
    poses[s] = {{Dot(rv[0], x), Dot(rv[1], x), Dot(rv[2], x)},
                {Dot(rv[0], y), Dot(rv[1], y), Dot(rv[2], y)},
                {v.x * depth, v.y * depth, depth}};
    Orthonormalize(&poses[s]);
  }
  return true;
}

}  // namespace topotag
