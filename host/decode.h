#ifndef TOPOTAG_HOST_DECODE_H_
#define TOPOTAG_HOST_DECODE_H_

#include <array>
#include <cstdint>

#include "host/homography.h"
#include "host/node_levels.h"
#include "host/tree.h"
#include "topotag/detection.h"

namespace topotag {

/// What decoding knows of a marker.
struct Decoded {
  Family family{Family::kMinN};
  uint64_t id = 0;
  TagMap map;            ///< fitted to the centroids of all nodes
  double node_area = 9;  ///< median area of the nodes, holes included, in square units
  /// Vertices, as in VertexBits, whose bit is not known, and those that are not to be measured:
  /// what hides a node, or touches it, would move them.
  uint64_t hidden = 0;
  uint64_t unmeasured = 0;
  /// Of the points of ModelTable, set by ConfirmBits.
  std::array<NodeLevels, kMaxPoints> levels;
  Quality quality;  ///< the rms is set with the vertices
};

/// Where a candidate was found, in pixels of the frame.
struct SearchArea {
  int x, y;    ///< of the first pixel of the image that was labelled
  int scale;   ///< pixels of that image per pixel of the frame, along each side
  Rect whole;  ///< all that is searched: what lies outside has not been seen

  /// Pixel of the labelled image to pixel of the frame.
  Point2 ToFrame(double px, double py) const {
    return {x + (px + 0.5) / scale - 0.5, y + (py + 0.5) / scale - 0.5};
  }
  /// Centroid of pixels of the labelled image, from their sums. The place of the area goes into
  /// these, which are integers: so it does not depend on which area around them was searched.
  Point2 CentroidInFrame(int64_t sum_x, int64_t sum_y, int64_t pixels) const {
    const double inverse = 1.0 / static_cast<double>(pixels);
    const auto from_origin = [&](int64_t sum, int first) {
      sum += int64_t{first} * scale * pixels;
      return (static_cast<double>(sum) * inverse + 0.5) / scale - 0.5;
    };
    return {from_origin(sum_x, x), from_origin(sum_y, y)};
  }
  Point2 CentroidInFrame(const Feature& feature) const {
    return CentroidInFrame(feature.sum_x, feature.sum_y, feature.area);
  }
};

/// Decodes a candidate: orders its nodes, confirms the grid and reads the ID. Paper: section 4.2,
/// ID decoding; here the order comes from the corners of the convex hull of all node centres, of
/// which p1 is one, and is confirmed by a homography fitted to all of them. Rejected is what does
/// not fit: mirrored markers, nodes off the grid or of the wrong size, holes off their nodes, and
/// markers clipped by the image's border.
/// @param camera  lens, or null: then the lens is taken as free of distortion
/// @return false where the candidate is no marker.
bool Decode(const Candidate& candidate, const Node* nodes, const Camera* camera,
            const SearchArea& area, Decoded* decoded);

/// Whether the horizon stays clear of the square of the given half side, units.
bool IsInFront(const Homography& map, double half);

}  // namespace topotag

#endif  // TOPOTAG_HOST_DECODE_H_
