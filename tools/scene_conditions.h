#ifndef TOPOTAG_TOOLS_SCENE_CONDITIONS_H_
#define TOPOTAG_TOOLS_SCENE_CONDITIONS_H_

#include "tools/json_node.h"
#include "topotag/renderer.h"

namespace topotag::tools {

/// Reads what stands between the markers and the picture:
/// {"exposure": S, "row_time": S,
///  "lighting": {"gain", "gradient": [X, Y], "vignetting",
///               "shadow": {"point": [X, Y], "angle", "factor", "penumbra"},
///               "highlights": [{"center": [X, Y], "sigma", "level"}]},
///  "occluders": [{"outline": [[X, Y], ...], "level", "marker"}]}
/// Needed are the point of a shadow, the centre of a highlight and the outline of an occluder.
/// @throws Error (kParse) that names the key, and the highlight or occluder by its index
void ReadConditions(const JsonNode& node, Scene* scene);

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_SCENE_CONDITIONS_H_
