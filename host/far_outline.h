#ifndef TOPOTAG_HOST_FAR_OUTLINE_H_
#define TOPOTAG_HOST_FAR_OUTLINE_H_

#include <vector>

#include "host/pipeline.h"
#include "topotag/geometry.h"

namespace topotag {

/// Finds the quadrilateral that a component fills.
class FarOutline {
 public:
  /// @param root   of the component
  /// @param white  its area and bounding box
  /// @param quad   its corners, clockwise on the screen, pixels of the labelled image
  /// @return false where its convex hull is no quadrilateral.
  bool Find(const Components& components, uint32_t root, const Feature& white, Point2 quad[4]);

 private:
  std::vector<Point2> points_, hull_;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_FAR_OUTLINE_H_
