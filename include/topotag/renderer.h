#ifndef TOPOTAG_RENDERER_H_
#define TOPOTAG_RENDERER_H_

#include <cstdint>
#include <optional>
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
  double tag_size = 0.05;  ///< side of the white area (4n+1 units), metres, 1e-9 .. 1e6
  Matrix3 R{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Vector3 t{0, 0, 1};
  double black = 25;  ///< of the ink; MarkerDesign::inverted says where it is
  double white = 215;
  /// By which black areas have grown on all their sides, white ones shrunk (ink that spreads);
  /// -0.4 .. 0.4 units.
  double growth = 0;
  /// Motion while the frame is taken (Scene::exposure, row_time), in the camera's axes: of the
  /// origin, metres a second, and a rotation vector a second about it, radians. R and t are those
  /// in the middle of the exposure of the row on which the origin appears.
  Vector3 velocity{};
  Vector3 angular_velocity{};
};

/// The straight edge of a shadow that falls on everything. Pixels, before the lens's blur.
struct Shadow {
  Point2 point;         ///< on the edge, in the middle of the penumbra
  double angle = 0;     ///< from the light into the shadow: (cos, sin), radians
  double factor = 0.5;  ///< share of the light that is left in the full shadow, 0 .. 1
  double penumbra = 0;  ///< width of the linear transition, 0 .. 10000
};

/// Light that is added as if reflected: a Gaussian spot.
struct Highlight {
  Point2 center;       ///< pixels
  double sigma = 20;   ///< pixels, > 0
  double level = 100;  ///< at its centre, grey levels, -255 .. 1e6
};

/// A pixel's level times gain * (1 + gradient . (pixel - middle of the frame)) * (1 - vignetting
/// * r^2), r = 1 in the corners of the frame; then plus highlights. Saturates at 0 and 255.
struct Lighting {
  double gain = 1;        ///< 0 .. 1000
  Point2 gradient;        ///< change a pixel
  double vignetting = 0;  ///< 0 .. 1
  std::optional<Shadow> shadow;
  std::vector<Highlight> highlights;
};

/// Something in front of all markers, of one grey level.
struct Occluder {
  std::vector<Point2> outline;  ///< a simple polygon
  double level = 40;
  /// The marker in whose plane it lies, moving with it; outline in its units. -1: in pixels.
  int marker = -1;
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
  double exposure = 0;           ///< time of each row's exposure, seconds: motion blur
  double row_time = 0;           ///< from one row's exposure to the next one's, seconds, any sign
  Lighting lighting;
  std::vector<Occluder> occluders;  ///< later ones cover earlier ones
};

/// Renders by exact integration of the projected outlines over each pixel, lens and point spread
/// function included, without a sampling grid: before noise and rounding, pixels are right to
/// 1e-3 grey levels for the outlines, which follow circles and lens distortion to 5e-4 pixels.
/// A background image is taken as already photographed: it is neither blurred again nor moved.
/// Motion is averaged over so many instants that this holds for blur of 0.3 pixels and more.
/// @throws Error (kInvalidArgument): a value out of range, a marker that is not wholly in front
///         of the camera, or whose part in the frame is beyond the lens model's range; the
///         message names the marker by its index.
Image RenderScene(const Scene& scene);

/// Exact projections of the marker, in the form of a detection, also where they lie outside the
/// frame. The pose is the scene's, with rms_px = 0 and zero covariance.
/// @throws Error (kInvalidArgument): a value out of range, this marker's design, a point that
///         RenderScene could not project; an index out of range.
Detection GroundTruth(const Scene& scene, int marker);

}  // namespace topotag

#endif  // TOPOTAG_RENDERER_H_
