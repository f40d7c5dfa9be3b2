#ifndef TOPOTAG_HOST_VERTICES_H_
#define TOPOTAG_HOST_VERTICES_H_

#include "host/decode.h"
#include "topotag/detection.h"
#include "topotag/image.h"

namespace topotag {

/// Weight of the squared residuals of p1 and p2 in a fit: they are measured together, as one shape.
inline constexpr double kBaselineWeight = 0.5;

/// Sub-pixel vertices: grey-level centroids on the original image. Paper: section 4.3.
///
/// A node's support is its square of 3 units grown by delta = max(2 px, l / 10), l being its side
/// in pixels, but never beyond the middle of the gap, so that it does not reach a neighbour. The
/// baseline node is measured as a whole; p1 and p2 follow from it under the homography of all
/// measured nodes. The centroid of a projected shape is not the projection of its centre: the
/// difference under perspective, to second order, is taken off (docs/design.md).
/// @param image    the whole frame
/// @param decoded  confirmed by ConfirmBits; its map is refitted to what is measured
/// A node without contrast keeps its place under the map.
void RefineVertices(const ImageView& image, Decoded* decoded, VertexList* vertices);

}  // namespace topotag

#endif  // TOPOTAG_HOST_VERTICES_H_
