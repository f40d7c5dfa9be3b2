#ifndef TOPOTAG_HOST_FAR_POSE_H_
#define TOPOTAG_HOST_FAR_POSE_H_

#include "host/far_fit.h"
#include "topotag/detection.h"

namespace topotag {

/// Covariance of a pose that was estimated from vertices of a fitted map, which has all their
/// errors in common: that of the map's parameters, taken through the least-squares solution.
/// @param tag_size  side of the white area, metres
void SetFarCovariance(Family family, const FarReading& reading, const Camera& camera,
                      double tag_size, Pose* pose);

}  // namespace topotag

#endif  // TOPOTAG_HOST_FAR_POSE_H_
