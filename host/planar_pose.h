#ifndef TOPOTAG_HOST_PLANAR_POSE_H_
#define TOPOTAG_HOST_PLANAR_POSE_H_

#include "host/homography.h"
#include "topotag/geometry.h"

namespace topotag {

/// x_camera = x p.x + y p.y + t for the tag's point p; lengths in units. x and y are the first two
/// columns of the rotation.
struct Rigid {
  Vector3 x, y, t;
};

inline double Dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <typename T>
std::array<T, 3> Cross(const std::array<T, 3>& a, const std::array<T, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline Vector3 Scaled(const Vector3& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }

/// Makes the columns a rotation's again: the nearest direction of x, y perpendicular to it.
void Orthonormalize(Rigid* pose);

/// The two poses of infinitesimal plane-based pose estimation (Collins and Bartoli, IJCV 2014) at
/// the model's origin.
/// @param normalized  tag units to normalised coordinates (x / z, y / z)
/// @return false where the map is none of a plane.
bool PlanarPoses(const Homography& normalized, Rigid poses[2]);

}  // namespace topotag

#endif  // TOPOTAG_HOST_PLANAR_POSE_H_
