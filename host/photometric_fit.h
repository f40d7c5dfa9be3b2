#ifndef TOPOTAG_HOST_PHOTOMETRIC_FIT_H_
#define TOPOTAG_HOST_PHOTOMETRIC_FIT_H_

#include "host/buffer.h"
#include "host/photometric_model.h"
#include "host/photometric_pixels.h"
#include "host/photometric_state.h"
#include "host/planar_pose.h"
#include "topotag/camera.h"
#include "topotag/geometry.h"
#include "topotag/image.h"

namespace topotag {

/// Memory of one fit, kept between fits.
struct PhotometricWorkspace {
  PixelWorkspace pixels;
  Buffer<float> residuals;

  void Reserve() {
    pixels.Reserve();
    residuals.Reserve(6 * kMaxPhotometricPixels + 3 * kPixelLanes);
  }
};

struct PhotometricFit {
  PhotometricState state;
  double sigma;          ///< of the residuals, robust, grey levels
  double noise;          ///< of the image: what neighbouring residuals differ by
  double cost;           ///< mean of Huber's function of the residuals, in squared grey levels
  double outliers;       ///< share of the pixels whose residuals are far beyond sigma
  double missing_holes;  ///< share of the holes that the image does not show
  int pixels;
  bool converged;
  Matrix6 covariance;  ///< of (w, dt): R' = exp(w) R, t' = t + dt; lengths in units
};

/// Fits the image of a marker: pose, grey levels, blur and growth of its black areas, by
/// Levenberg-Marquardt with Huber's weights on the pixels near edges.
/// @param start  pose to within about a pixel, levels and blur roughly
/// @return false where too little of the marker is seen, or the fit does not converge
bool FitPhotometric(const ImageView& image, const UnitPattern& pattern, const Camera& camera,
                    const PhotometricState& start, PhotometricWorkspace* workspace,
                    PhotometricFit* fit);

}  // namespace topotag

#endif  // TOPOTAG_HOST_PHOTOMETRIC_FIT_H_
