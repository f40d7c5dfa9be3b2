#ifndef TOPOTAG_TESTS_OBJECT_UTIL_H_
#define TOPOTAG_TESTS_OBJECT_UTIL_H_

#include <cmath>
#include <vector>

#include "tests/scene_util.h"
#include "topotag/object.h"
#include "topotag/renderer.h"

namespace topotag::test {

/// x_camera = R x_object + t.
struct ObjectPlace {
  Matrix3 R{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Vector3 t{0, 0, 0.4};
};

inline Matrix3 RotationY(double a) {
  return {{{std::cos(a), 0, std::sin(a)}, {0, 1, 0}, {-std::sin(a), 0, std::cos(a)}}};
}

inline Vector3 Rotated(const Matrix3& r, const Vector3& v) {
  Vector3 result{};
  for (int i = 0; i < 3; ++i) result[i] = r[i][0] * v[0] + r[i][1] * v[1] + r[i][2] * v[2];
  return result;
}

inline SceneMarker Placed(const ObjectMarker& marker, const ObjectPlace& place) {
  SceneMarker result;
  result.design.family = marker.family;
  result.design.id = marker.id;
  result.tag_size = marker.tag_size;
  result.R = place.R * marker.R;
  result.t = Rotated(place.R, marker.t);
  for (int i = 0; i < 3; ++i) result.t[i] += place.t[i];
  return result;
}

/// Whether a marker's front is seen at less than about 85 degrees.
inline bool IsTurnedToCamera(const SceneMarker& marker) {
  const Vector3 z{marker.R[0][2], marker.R[1][2], marker.R[2][2]};
  return z[0] * marker.t[0] + z[1] * marker.t[1] + z[2] * marker.t[2] > 0.09 * Norm(marker.t);
}

/// The markers of a convex object that are turned to the camera, without each `hide`-th of the
/// object's, a different choice for each `phase`; hide = 0: all of them.
inline std::vector<SceneMarker> VisibleMarkers(const Object& object, const ObjectPlace& place,
                                               size_t hide = 0, size_t phase = 0) {
  std::vector<SceneMarker> visible;
  for (size_t i = 0; i < object.markers.size(); ++i) {
    if (hide != 0 && (7 * i + phase) % hide == 0) continue;
    const SceneMarker marker = Placed(object.markers[i], place);
    if (IsTurnedToCamera(marker)) visible.push_back(marker);
  }
  return visible;
}

/// Exact detections of a scene's markers, without poses.
inline std::vector<Detection> ExactDetections(const Scene& scene) {
  std::vector<Detection> detections;
  for (size_t i = 0; i < scene.markers.size(); ++i) {
    detections.push_back(GroundTruth(scene, static_cast<int>(i)));
    detections.back().pose.reset();
  }
  return detections;
}

/// Adds noise to the vertices, pixels.
inline void Disturb(double sigma, Random* random, std::vector<Detection>* detections) {
  for (Detection& detection : *detections) {
    for (Point2& vertex : detection.vertices) {
      vertex.x += sigma * random->Gaussian();
      vertex.y += sigma * random->Gaussian();
    }
  }
}

}  // namespace topotag::test

#endif  // TOPOTAG_TESTS_OBJECT_UTIL_H_
