#ifndef TOPOTAG_HOST_VERTICES_H_
#define TOPOTAG_HOST_VERTICES_H_

#include "host/decode.h"
#include "topotag/detection.h"
#include "topotag/image.h"

namespace topotag {

/// How precise a vertex measured at a hole (p1, p2) is beside one measured at a node: the weight
/// of its squared residual. The signal of a hole is weaker by more than its support is smaller.
inline constexpr double kHoleWeight = 0.25;

/// Sub-pixel vertices: grey-level centroids on the original image. Paper: section 4.3.
///
/// A node's support is its square of 3 units grown by delta = max(2 px, l / 10), l being its side
/// in pixels, but never beyond its cell, so that it does not reach a neighbour; p1 and p2 are
/// measured in the same way at the white holes of the baseline node. The centroid of a projected
/// shape is not the projection of its centre: the difference under perspective, to second order,
/// is taken off (docs/design.md).
/// @param image  the whole frame
/// A vertex without contrast keeps its place under decoded.map.
void RefineVertices(const ImageView& image, const Decoded& decoded, VertexList* vertices);

/// Refits decoded->map to the vertices.
/// @return false where they do not determine it.
bool RefitMap(const VertexList& vertices, Decoded* decoded);

}  // namespace topotag

#endif  // TOPOTAG_HOST_VERTICES_H_
