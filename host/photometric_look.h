#ifndef TOPOTAG_HOST_PHOTOMETRIC_LOOK_H_
#define TOPOTAG_HOST_PHOTOMETRIC_LOOK_H_

#include "host/photometric_pixels.h"
#include "host/planar_pose.h"
#include "topotag/camera.h"
#include "topotag/family.h"
#include "topotag/geometry.h"
#include "topotag/image.h"
#include "topotag/marker.h"

namespace topotag {

// What a marker looks like, from a few grey levels at places that its pose tells; lengths of the
// pose in units.

Point2 ToPixel(const Camera& camera, const Rigid& pose, Point2 tag);

/// Side of a unit in pixels, over the whole marker.
double UnitPixels(const Camera& camera, const Rigid& pose, Family family);

/// What the places of a marker's model look like in the image.
class MarkerLook {
 public:
  MarkerLook(const ImageView& image, const Camera& camera, const Rigid& pose, Family family);

  double black() const { return black_; }
  double white() const { return white_; }
  /// What of the surroundings the image shows.
  KnownOutline FindOutline() const;
  /// The shape of nodes and holes.
  InnerShape FindShape() const;

 private:
  // Grey levels along a square outline around the tag's centre.
  struct Ring {
    int count = 0, missing = 0;
    double mean = 0, deviation = 0;
  };

  bool LevelAtTag(Point2 tag, double* level) const;
  Ring MeasureRing(double half) const;
  // Mean level at two of (+-x, +-y) from the centres of all nodes but the baseline node.
  double MeanAround(double x, double y) const;

  const ImageView& image_;
  const Camera& camera_;
  const Rigid& pose_;
  const Family family_;
  Vector3 x_, y_, z_;  // rows of the map from the tag to pixels, without lens
  double black_;       // between the edges of the nodes and of their holes
  double white_;       // where two gaps cross
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_PHOTOMETRIC_LOOK_H_
