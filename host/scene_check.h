#ifndef TOPOTAG_HOST_SCENE_CHECK_H_
#define TOPOTAG_HOST_SCENE_CHECK_H_

#include "topotag/renderer.h"

namespace topotag {

/// Checks all values of a scene but those of its markers, which TagProjector and PaintMarker do.
/// @throws Error (kInvalidArgument) that names the field, and the occluder or highlight by its
///         index.
void ValidateScene(const Scene& scene);

}  // namespace topotag

#endif  // TOPOTAG_HOST_SCENE_CHECK_H_
