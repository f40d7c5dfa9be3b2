#ifndef TOPOTAG_HOST_POSE_H_
#define TOPOTAG_HOST_POSE_H_

#include <algorithm>
#include <cmath>

#include "host/homography.h"
#include "topotag/detection.h"

namespace topotag {

/// Pose of a marker from its vertices. Paper: section 4.3, pose estimation.
///
/// Start: both solutions of the planar pose problem in closed form from the homography (Collins
/// and Bartoli, "Infinitesimal plane-based pose estimation", IJCV 2014). Then Levenberg-Marquardt
/// on the reprojection error of all vertices in pixels, lens included. The better one is the
/// pose, the other one, where it stays a different minimum, the alternative.
/// @param map       tag units to ideal pixels of `camera`
/// @param tag_size  side of the white area, metres
/// @param unmeasured  vertices without weight, as in VertexBits; at least 4 are left
/// @return false where no solution lies in front of the camera.
bool EstimatePose(Family family, const VertexList& vertices, const Homography& map,
                  const Camera& camera, double tag_size, Pose* pose, uint64_t unmeasured = 0);

/// Whether all numbers of R and t are.
inline bool IsFinite(const PoseSolution& pose) {
  const auto is_finite = [](double value) { return std::isfinite(value); };
  return std::all_of(pose.t.begin(), pose.t.end(), is_finite) &&
         std::all_of(pose.R.begin(), pose.R.end(), [&](const Vector3& row) {
           return std::all_of(row.begin(), row.end(), is_finite);
         });
}

}  // namespace topotag

#endif  // TOPOTAG_HOST_POSE_H_
