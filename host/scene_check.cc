#include "host/scene_check.h"

#include <cmath>
#include <string>

#include "host/check.h"
#include "host/outline.h"

namespace topotag {
namespace {

constexpr double kMaxBlur = 100;
constexpr double kMaxPixel = 1e6;  // of coordinates and widths
constexpr double kMaxSeconds = 100;
constexpr size_t kMaxPoints = 4000;  // of an outline, whose check takes quadratic time

void RequirePoint(const std::string& name, Point2 p) {
  RequireRange(name + ": x", p.x, -kMaxPixel, kMaxPixel);
  RequireRange(name + ": y", p.y, -kMaxPixel, kMaxPixel);
}

void ValidateLighting(const Lighting& lighting) {
  const std::string name = "scene: lighting: ";
  RequireRange(name + "gain", lighting.gain, 0, 1000);
  RequirePoint(name + "gradient", lighting.gradient);
  RequireRange(name + "vignetting", lighting.vignetting, 0, 1);
  if (lighting.shadow) {
    RequirePoint(name + "shadow: point", lighting.shadow->point);
    RequireRange(name + "shadow: angle", lighting.shadow->angle, -1000, 1000);
    RequireRange(name + "shadow: factor", lighting.shadow->factor, 0, 1);
    RequireRange(name + "shadow: penumbra", lighting.shadow->penumbra, 0, 10000, "pixels");
  }
  for (size_t i = 0; i < lighting.highlights.size(); ++i) {
    const Highlight& highlight = lighting.highlights[i];
    const std::string which = name + "highlight " + std::to_string(i);
    RequirePoint(which + ": center", highlight.center);
    RequireRange(which + ": sigma", highlight.sigma, 1e-3, kMaxPixel, "pixels");
    RequireRange(which + ": level", highlight.level, -255, 1e6);
  }
}

void ValidateOccluder(const Occluder& occluder, int markers, const std::string& name) {
  RequireRange(name + ": level", occluder.level, 0, 255);
  if (occluder.marker < -1 || occluder.marker >= markers) {
    FailArgument(name + ": marker " + std::to_string(occluder.marker) +
                 " is not one of the scene's " + std::to_string(markers));
  }
  if (occluder.outline.size() > kMaxPoints) {
    FailArgument(name + ": the outline has more than " + std::to_string(kMaxPoints) + " points");
  }
  for (const Point2& p : occluder.outline) RequirePoint(name + ": outline", p);
  if (occluder.outline.size() < 3 || !IsSimple(occluder.outline)) {
    FailArgument(name + ": the outline is not a simple polygon");
  }
}

}  // namespace

void ValidateScene(const Scene& scene) {
  ValidateCamera(scene.camera);
  for (const int side : {scene.camera.width, scene.camera.height}) {
    if (side >= 1 && side <= kMaxImageSide) continue;
    FailArgument("scene: the camera's image size " + Text(scene.camera.width, scene.camera.height) +
                 " is not within 1x1 .. " + Text(kMaxImageSide, kMaxImageSide));
  }
  RequireRange("scene: background", scene.background, 0, 255);
  RequireRange("scene: blur", scene.blur, 0, kMaxBlur);
  RequireRange("scene: noise", scene.noise, 0, 1e6);
  RequireRange("scene: exposure", scene.exposure, 0, kMaxSeconds, "s");
  RequireRange("scene: row time", scene.row_time, -kMaxSeconds, kMaxSeconds, "s");
  if (scene.background_image.data != nullptr) ValidateImage(scene.background_image);
  ValidateLighting(scene.lighting);
  for (size_t i = 0; i < scene.occluders.size(); ++i) {
    ValidateOccluder(scene.occluders[i], static_cast<int>(scene.markers.size()),
                     "occluder " + std::to_string(i));
  }
}

}  // namespace topotag
