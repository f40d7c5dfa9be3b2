#ifndef TOPOTAG_RENDERER_H_
#define TOPOTAG_RENDERER_H_

#include <cstdint>
#include <vector>

#include "topotag/camera.h"
#include "topotag/detection.h"
#include "topotag/image.h"
#include "topotag/marker.h"

namespace topotag {

/// A marker in the scene: x_camera = R x_tag + t, metres, grey levels 0 .. 255. Seen from behind
/// it appears mirrored, as if printed on glass.
struct SceneMarker {
  MarkerDesign design;
  double tag_size = 0.05;  ///< side of the white area (4n+1 units), metres
  Matrix3 R{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Vector3 t{0, 0, 1};
  double black = 25;
  double white = 215;
};

/// A scene with exact ground truth. Later markers cover earlier ones.
struct Scene {
  Camera camera;  ///< width and height are the frame's size
  std::vector<SceneMarker> markers;
  double background = 90;        ///< grey level where there is no background image
  ImageView background_image{};  ///< optional, scaled to cover the frame; data may be null
  double blur = 0.7;             ///< sigma of the Gaussian point spread function, 0 .. 100 pixels
  double noise = 2;              ///< sigma of additive Gaussian noise, grey levels
  uint64_t seed = 1;             ///< of the noise; the same seed gives the same frame everywhere
};

/// Renders by exact integration of the projected outlines over each pixel, lens and point spread
/// function included, without a sampling grid: before noise and rounding, pixels are right to
/// 1e-3 grey levels for the outlines, which follow circles and lens distortion to 5e-4 pixels.
/// A background image is taken as already photographed: it is not blurred again.
/// @throws Error (kInvalidArgument): a value out of range, a marker that is not wholly in front
///         of the camera, or whose part in the frame is beyond the lens model's range; the
///         message names the marker by its index.
Image RenderScene(const Scene& scene);

/// Exact projections of the marker, in the form of a detection, also where they lie outside the
/// frame. The pose is the scene's, with rms_px = 0 and zero covariance.
/// @throws Error (kInvalidArgument) like RenderScene, or for an index out of range.
Detection GroundTruth(const Scene& scene, int marker);

}  // namespace topotag

#endif  // TOPOTAG_RENDERER_H_
