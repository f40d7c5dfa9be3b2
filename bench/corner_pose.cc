#include "bench/corner_pose.h"

#ifdef TOPOTAG_BENCH_WITH_CALIB3D
#include <opencv2/calib3d.hpp>
#include <vector>

#include "host/rotation.h"
#endif

namespace topotag::bench {

#ifdef TOPOTAG_BENCH_WITH_CALIB3D
std::optional<PoseSolution> PoseOfCorners(const std::array<Point2, 4>& corners, double side,
                                          const Camera& camera, bool refine) {
  const double h = side / 2;
  const std::vector<cv::Point3d> model{{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}};
  std::vector<cv::Point2d> image;
  for (const Point2& p : corners) image.emplace_back(p.x, p.y);
  const cv::Matx33d intrinsics(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  cv::Vec3d rotation, translation;
  const bool found = cv::solvePnP(model, image, intrinsics, cv::noArray(), rotation, translation,
                                  false, cv::SOLVEPNP_IPPE);
  if (!found) return std::nullopt;
  if (refine) {
    cv::solvePnPRefineLM(model, image, intrinsics, cv::noArray(), rotation, translation);
  }
  PoseSolution pose;
  pose.R = Exp({rotation[0], rotation[1], rotation[2]});
  pose.t = {translation[0], translation[1], translation[2]};
  return pose;
}
#else
std::optional<PoseSolution> PoseOfCorners(const std::array<Point2, 4>&, double, const Camera&,
                                          bool) {
  return std::nullopt;
}
#endif

}  // namespace topotag::bench
