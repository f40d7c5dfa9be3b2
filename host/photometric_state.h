#ifndef TOPOTAG_HOST_PHOTOMETRIC_STATE_H_
#define TOPOTAG_HOST_PHOTOMETRIC_STATE_H_

#include <array>

#include "host/photometric_model.h"
#include "host/photometric_pixels.h"
#include "host/planar_pose.h"
#include "topotag/camera.h"

namespace topotag {

/// The unknowns of a fit.
struct PhotometricState {
  Rigid pose;  ///< lengths in units
  double black, white;
  double gain_x, gain_y;       ///< a unit
  std::array<double, 3> blur;  ///< covariance, pixel included: xx, xy, yy
  double growth;               ///< units
  double background;
};

/// Changes of the unknowns, in the order of PhotometricUnknown.
using PhotometricStep = std::array<double, kPhotometricUnknowns>;

/// The unknowns after a step; blur and growth are kept within bounds.
PhotometricState Apply(const PhotometricState& state, const PhotometricStep& step);

PixelView MakeView(const Camera& camera, const PhotometricState& state);

/// For pixels that were collected in the view `origin`.
PhotometricModel MakeModel(const Camera& camera, const PixelView& origin,
                           const PhotometricState& state, double huber);

}  // namespace topotag

#endif  // TOPOTAG_HOST_PHOTOMETRIC_STATE_H_
