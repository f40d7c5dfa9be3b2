#ifndef TOPOTAG_BENCH_CORNER_POSE_H_
#define TOPOTAG_BENCH_CORNER_POSE_H_

#include <array>
#include <optional>

#include "topotag/camera.h"
#include "topotag/detection.h"

namespace topotag::bench {

/// The pose of a square from its corners by OpenCV: solvePnP with SOLVEPNP_IPPE, the solution of
/// the smaller reprojection error, and where `refine`, solvePnPRefineLM after it.
/// @param corners  clockwise from (-side/2, -side/2), pixels; @param side  metres.
/// @return nothing where OpenCV finds none, or in a build without its calib3d module.
std::optional<PoseSolution> PoseOfCorners(const std::array<Point2, 4>& corners, double side,
                                          const Camera& camera, bool refine);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_CORNER_POSE_H_
