#ifndef TOPOTAG_HOST_OBJECT_SIGHTING_H_
#define TOPOTAG_HOST_OBJECT_SIGHTING_H_

#include <map>
#include <utility>

#include "host/object_system.h"
#include "topotag/object.h"

namespace topotag {

/// Finds markers of an object by family and ID.
class ObjectIndex {
 public:
  explicit ObjectIndex(const Object& object);
  /// Index of a marker of the object, or -1.
  int Find(Family family, uint64_t id) const;

 private:
  std::map<std::pair<int, uint64_t>, int> markers_;  ///< by (family n, ID)
};

/// What one frame says about the pose of one marker of an object: its vertices or, where these are
/// not all that is known or not measured one by one (a photometric pose, a far marker, a part of
/// one), its pose and the covariance of that.
struct Sighting {
  int detection = 0;  ///< index in the frame's list
  int marker = 0;     ///< index in the object
  double side = 0;    ///< of the grid of vertices, mean of the four, pixels
  MarkerVertices vertices;
  double weight = 0;  ///< 1 / variance of the noise of a vertex coordinate, pixels^-2
  bool by_pose = false;
  Matrix6 information{};  ///< of poses[0]: inverse covariance
  int pose_count = 0;
  RigidTransform poses[2];  ///< x_camera = pose * x_tag, metres; the better one first

  /// Number of independent measurements.
  int Freedom() const { return by_pose ? 6 : 2 * vertices.pixels->size(); }
  /// Mean square of the reprojection errors, pixels^2.
  double MeanSquare(const Camera& camera, const RigidTransform& marker_pose) const {
    return ReprojectionSquares(camera, marker_pose, vertices) / vertices.pixels->size();
  }
  /// The equations of the errors in standard deviations; as EvaluateView and EvaluateMarker.
  PoseEquations ByView(const Camera& camera, const RigidTransform& view,
                       const RigidTransform& on_object) const;
  MarkerEquations ByMarker(const Camera& camera, const RigidTransform& view,
                           const RigidTransform& on_object) const;
};

/// @param detection  the sighting points into it
/// @return false where the vertices give no pose, or a pose is needed and is not there or that of
///         another size.
bool MakeSighting(const Detection& detection, const Camera& camera, double tag_size,
                  Sighting* sighting);

}  // namespace topotag

#endif  // TOPOTAG_HOST_OBJECT_SIGHTING_H_
