#ifndef TOPOTAG_HOST_MOTION_H_
#define TOPOTAG_HOST_MOTION_H_

#include <vector>

#include "topotag/renderer.h"

namespace topotag {

/// True where the marker is seen at more than one instant.
bool Moves(const Scene& scene, const SceneMarker& marker);

/// The marker where it is `seconds` after the instant of its R and t.
SceneMarker MovedMarker(const SceneMarker& marker, double seconds);

/// An instant of an exposure and its share of the light.
struct Instant {
  double time;  // seconds after that of the marker's R and t
  double weight;
};

/// The instants whose weighted sum is the exposure of row y by the scene's marker `index`.
/// @throws Error (kInvalidArgument) where the marker is not in front of the camera all the time.
std::vector<Instant> ExposureInstants(const Scene& scene, int index, double y);

}  // namespace topotag

#endif  // TOPOTAG_HOST_MOTION_H_
