#ifndef TOPOTAG_HOST_OBJECT_BUNDLE_H_
#define TOPOTAG_HOST_OBJECT_BUNDLE_H_

#include <vector>

#include "host/object_sighting.h"

namespace topotag {

/// The markers that one view shows, where it shows the object.
struct BundleView {
  const Camera* camera;
  RigidTransform pose;  ///< x_camera = pose * x_object
  std::vector<Sighting> sightings;
};

/// Bundle adjustment of the poses of markers on an object and of the object in views, by
/// Levenberg-Marquardt. The first marker stays where it is; every other one must be in a view that
/// also shows one that is joined to the first.
class ObjectBundle {
 public:
  /// Both are changed in place by Adjust().
  ObjectBundle(std::vector<RigidTransform>* markers, std::vector<BundleView>* views);

  /// @return false where the views do not determine the markers.
  bool Adjust();
  /// Covariance of the steps (w, dt) of all markers but the first: square, row-major, of side
  /// unknowns(). After Adjust().
  /// @return false as Adjust().
  bool Covariance(std::vector<double>* covariance);
  int unknowns() const { return unknowns_; }

 private:
  double Cost() const;
  double Build();
  bool Reduce(double damping);
  double Step(double damping);

  std::vector<RigidTransform>& markers_;
  std::vector<BundleView>& views_;
  int unknowns_;
  std::vector<MarkerEquations> equations_;  ///< of all sightings, view by view
  std::vector<double> reduced_;             ///< matrix of the markers, the views eliminated
  std::vector<double> right_;               ///< minus the gradient; then the markers' steps
  std::vector<Matrix6> factors_;            ///< of each view's damped matrix
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_OBJECT_BUNDLE_H_
