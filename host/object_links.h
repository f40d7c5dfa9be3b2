#ifndef TOPOTAG_HOST_OBJECT_LINKS_H_
#define TOPOTAG_HOST_OBJECT_LINKS_H_

#include <cmath>
#include <vector>

#include "host/object_sighting.h"

namespace topotag {

/// One view of a pair of markers.
struct PairView {
  double side;  ///< of the smaller marker, pixels
  const Sighting* first;
  const Sighting* second;
};

/// Where the second marker of a pair is on the first: x_first = pose * x_second.
struct Link {
  int views = 0;    ///< that agree
  double side = 0;  ///< of the smaller marker in the view that it is from, pixels
  RigidTransform pose;

  bool IsBetterThan(const Link& other) const {
    return views != other.views ? views > other.views : side > other.side;
  }
  /// How little is known of it, relative to others. Two views that agree say much more than one,
  /// which may show the wrong one of two planar solutions.
  double Doubt() const { return views == 0 ? INFINITY : 1 / (side * side * views * views); }
};

/// The relative pose of a pair of markers that most of its views agree with.
/// @param views  not empty
/// @param size   of the two markers together, metres
Link BestLink(std::vector<PairView> views, double size);

}  // namespace topotag

#endif  // TOPOTAG_HOST_OBJECT_LINKS_H_
