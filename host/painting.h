#ifndef TOPOTAG_HOST_PAINTING_H_
#define TOPOTAG_HOST_PAINTING_H_

#include <vector>

#include "topotag/marker.h"
#include "topotag/renderer.h"

namespace topotag {

/// An area of one grey level in the plane of a marker.
struct PaintedArea {
  std::vector<Outline> outlines;  ///< one, or two equal ones that TessellateUnion joins; units
  double level = 0;
  double ground = 0;  ///< the level that it is painted on
};

/// What a plane shows, each area painted over the ones before. The first is the silhouette, which
/// contains the others; its ground is the scene.
using Painting = std::vector<PaintedArea>;

/// @throws Error (kInvalidArgument): the design's, growth out of range.
Painting PaintMarker(const SceneMarker& marker);

}  // namespace topotag

#endif  // TOPOTAG_HOST_PAINTING_H_
