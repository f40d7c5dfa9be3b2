// Scenes with exact ground truth: the levels of SceneLevels, with noise, in whole grey levels.
#include "topotag/renderer.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "host/check.h"
#include "host/painting.h"
#include "host/scene_check.h"
#include "host/scene_levels.h"
#include "host/tag_projector.h"

namespace topotag {
namespace {

// Bounds the memory of the accumulation, whatever the frame's size.
constexpr int kBandPixels = 1 << 19;

/// Gaussian noise, equal everywhere: std::normal_distribution differs between standard libraries.
class Noise {
 public:
  Noise(uint64_t seed, double sigma) : engine_(seed), sigma_(sigma) {}

  double Next() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    // Box-Muller; the first number is in (0, 1] for the logarithm.
    const double radius = sigma_ * std::sqrt(-2 * std::log(1 - Uniform()));
    const double angle = 2 * M_PI * Uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

 private:
  double Uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

  std::mt19937_64 engine_;
  double sigma_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace

Image DevelopFrame(const Scene& scene, SceneLevels* levels) {
  const int width = scene.camera.width, height = scene.camera.height;
  Image frame(width, height);
  Noise noise(scene.seed, scene.noise);
  const int band_rows = std::max(1, kBandPixels / width);
  std::vector<double> values;
  for (int y0 = 0; y0 < height; y0 += band_rows) {
    const Rect band{0, y0, width, std::min(band_rows, height - y0)};
    levels->Render(band, &values);
    for (int y = 0; y < band.height; ++y) {
      const double* in = values.data() + static_cast<size_t>(y) * width;
      uint8_t* out = frame.row(y0 + y);
      for (int x = 0; x < width; ++x) {
        const double value = scene.noise > 0 ? in[x] + noise.Next() : in[x];
        out[x] = static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
      }
    }
  }
  return frame;
}

Image RenderScene(const Scene& scene) {
  SceneLevels levels(scene);
  return DevelopFrame(scene, &levels);
}

Detection GroundTruth(const Scene& scene, int marker) {
  ValidateScene(scene);
  if (marker < 0 || marker >= static_cast<int>(scene.markers.size())) {
    FailArgument("marker " + std::to_string(marker) + " is not one of the scene's " +
                 std::to_string(scene.markers.size()));
  }
  const TagProjector project(scene, marker);
  const SceneMarker& truth = scene.markers[marker];
  PaintMarker(truth);  // refuses a design that cannot be drawn
  Detection detection;
  detection.family = truth.design.family;
  detection.id = truth.design.id;
  detection.inverted = truth.design.inverted;
  detection.center = project.Visible({0, 0});
  const double half = 0.5 * truth.design.family.white_side();
  detection.corners = {project.Visible({-half, -half}), project.Visible({half, -half}),
                       project.Visible({half, half}), project.Visible({-half, half})};
  const std::vector<Point2> vertices = ModelVertices(truth.design.family);
  detection.vertices.resize(static_cast<int>(vertices.size()));
  for (size_t v = 0; v < vertices.size(); ++v) {
    detection.vertices[static_cast<int>(v)] = project.Visible(vertices[v]);
  }
  Pose pose;
  pose.R = truth.R;
  pose.t = truth.t;
  detection.pose = pose;
  return detection;
}

}  // namespace topotag
