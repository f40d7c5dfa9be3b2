#ifndef TOPOTAG_CAMERA_H_
#define TOPOTAG_CAMERA_H_

#include <array>

#include "topotag/geometry.h"

namespace topotag {

enum class DistortionModel {
  kNone,
  kBrown,    ///< OpenCV's polynomial, rational, thin-prism and tilted model
  kFisheye,  ///< OpenCV's fisheye (equidistant) model
};

/// A pinhole camera with lens distortion, in OpenCV's conventions. Lengths in pixels.
struct Camera {
  int width = 0;   ///< calibrated image width; 0 = not stated
  int height = 0;  ///< calibrated image height; 0 = not stated
  double fx = 0;   ///< 1e-9 .. 1e9
  double fy = 0;   ///< 1e-9 .. 1e9
  double cx = 0;   ///< -1e9 .. 1e9
  double cy = 0;   ///< -1e9 .. 1e9
  DistortionModel model = DistortionModel::kNone;
  /// kBrown: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tau_x tau_y; kFisheye: k1 k2 k3 k4. Of any size:
  /// where they make no lens, Unproject says so.
  std::array<double, 14> distortion{};
};

/// @throws Error (kInvalidArgument): an unknown model, a focal length or a centre out of range, a
///         coefficient that is not finite, negative size, only one of width and height; the message
///         names the field.
void ValidateCamera(const Camera& camera);

/// Derivatives of a map of the plane: [[dx'/dx, dx'/dy], [dy'/dx, dy'/dy]], row-major.
using Jacobian2 = std::array<double, 4>;

/// Pixel of the ray (x/z, y/z). Optionally its Jacobian, pixels per unit of normalised coordinate.
Point2 Project(const Camera& camera, Point2 normalized, Jacobian2* jacobian = nullptr);

/// Inverse of Project on the branch that starts at the centre, to below 1e-9 of normalised
/// coordinate (fisheye: of the angle).
/// @return false, *normalized untouched, where the pixel lies outside the region in which the lens
///         model is provably one-to-one: beyond the radius at which it folds back, or so close to
///         it that tangential terms decide; for a pixel that is not finite.
bool Unproject(const Camera& camera, Point2 pixel, Point2* normalized);

}  // namespace topotag

#endif  // TOPOTAG_CAMERA_H_
