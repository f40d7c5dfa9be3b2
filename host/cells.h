#ifndef TOPOTAG_HOST_CELLS_H_
#define TOPOTAG_HOST_CELLS_H_

#include <cmath>

#include "host/homography.h"
#include "topotag/image.h"

namespace topotag {

/// Grey levels of an image at tag points, bilinear; NaN outside it.
class GreyReader {
 public:
  GreyReader(const ImageView& image, const TagMap& map) : image_(image), map_(map) {}
  float At(Point2 tag) const;

 private:
  const ImageView& image_;
  const TagMap& map_;
};

/// Black and white of a marker in a place: planes through what its nodes show.
struct InkLevels {
  struct Plane {
    double level = 0, x = 0, y = 0;
    double At(Point2 p) const { return level + x * p.x + y * p.y; }
  };
  Plane black, white;
};

/// Least-squares plane through `count` levels; flat where the points lie on a line.
InkLevels::Plane FitInkPlane(const Point2* at, const float* level, int count);

/// What the grey levels say of a grid's cell, which something may hide.
struct CellReading {
  /// A node is there: a dark body, and around it enough of the bright gap.
  bool is_node = false;
  /// A node of which body and gap are seen all around: nothing touches it.
  bool is_clean = false;
  /// If its centre is dark, it is the node's: the gap is seen around most of it. If it is bright:
  /// the body is.
  bool shows_dark_center = false, shows_bright_center = false;
  float hole = 0;  ///< brightness of the centre over the body, in parts of the contrast
};

/// Own levels of a cell that is known to be a node: the darker half of its body, the brighter half
/// of its gap.
void MeasureInk(const GreyReader& reader, Point2 center, float* black, float* white);

/// @param is_whole  the bit image has a node of its own there, of the right size
CellReading ReadCell(const GreyReader& reader, Point2 center, const InkLevels& ink, bool is_whole);

/// Whether the baseline node has p1 at `corner` and p2 two units along `x`; y is clockwise of it.
/// Its body must be dark, both holes bright, and the gap behind it, where a node of one cell would
/// be, white.
/// @param hole  brightness over the body, in parts of the contrast, that tells holes from none
/// @param holes  the brightness of both
/// @param is_clean  nothing touches it
bool IsBaseline(const GreyReader& reader, Point2 corner, Point2 x, Point2 y, const InkLevels& ink,
                float hole, float* holes, bool* is_clean);

}  // namespace topotag

#endif  // TOPOTAG_HOST_CELLS_H_
