#ifndef TOPOTAG_BENCH_CRAMER_RAO_H_
#define TOPOTAG_BENCH_CRAMER_RAO_H_

#include "topotag/renderer.h"

namespace topotag::bench {

/// What no unbiased estimate of a pose can do better than.
struct PoseBound {
  Matrix6 covariance{};  ///< of (rotation vector [rad], translation [m]), R' = exp(w) R
  /// Of the length of the error of an estimate that reaches the bound: half of all are below.
  double median_position = 0;  ///< metres
  double median_rotation = 0;  ///< radians
  double rms_position = 0;     ///< metres
  double rms_rotation = 0;     ///< radians
};

/// The Cramer-Rao bound of the pose of a scene's only marker, from all pixels that the marker
/// touches, of which each has the scene's noise and that of rounding (1/12). Black and white
/// level, the background's, a gain gradient along x and y, blur and ink growth are unknown, too.
/// The levels' derivatives are central differences of exact renders: without sampling grid, so
/// that no sampling jitter counts as information.
/// @param scene  plain background, black and white within 1 .. 254 by 1, sigma of blur >= 0.1.
/// @param step  of the differences, pixels that the marker's corners move by.
PoseBound CramerRaoBound(const Scene& scene, double step = 0.04);

/// Median of |e| for Gaussian e of mean 0, by sampling.
double MedianNorm(const Matrix3& covariance);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_CRAMER_RAO_H_
