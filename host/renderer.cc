// Scenes with exact ground truth. The marker's nested outlines are projected through pose and
// lens and integrated over the pixels by AreaRaster: each outline adds the difference of its grey
// level to its surroundings', so that any number of edges in one pixel add up exactly.
#include "topotag/renderer.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "host/area_raster.h"
#include "host/check.h"
#include "host/tag_projector.h"
#include "topotag/error.h"

namespace topotag {
namespace {

constexpr double kMaxBlur = 100;
// Bounds the memory of the accumulation, whatever the frame's size.
constexpr int kBandPixels = 1 << 19;

using Polygon = std::vector<Point2>;

void ValidateScene(const Scene& scene) {
  ValidateCamera(scene.camera);
  for (const int side : {scene.camera.width, scene.camera.height}) {
    if (side >= 1 && side <= kMaxImageSide) continue;
    FailArgument("scene: the camera's image size " + std::to_string(scene.camera.width) + "x" +
                 std::to_string(scene.camera.height) + " is not within 1x1 .. " +
                 std::to_string(kMaxImageSide) + "x" + std::to_string(kMaxImageSide));
  }
  RequireRange("scene: background", scene.background, 0, 255);
  RequireRange("scene: blur", scene.blur, 0, kMaxBlur);
  RequireRange("scene: noise", scene.noise, 0, 1e6);
  if (scene.background_image.data != nullptr) ValidateImage(scene.background_image);
}

struct Ink {
  Polygon outline;
  double level;  // grey levels, relative to what it is painted on
};

/// A marker in pixels: its silhouette in one grey level, and what is painted on it.
struct ProjectedMarker {
  Polygon silhouette;
  double level;
  std::vector<Ink> inks;
  Rect bounds;  // of all pixels that it touches, within the frame; may be empty
};

Rect TouchedPixels(const Polygon& outline, double reach, const Camera& camera) {
  Point2 low = outline[0], high = outline[0];
  for (const Point2& p : outline) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  const auto clip = [](double value, int size) {
    return static_cast<int>(std::clamp<double>(value, 0, size));
  };
  const int x0 = clip(std::floor(low.x - reach), camera.width);
  const int y0 = clip(std::floor(low.y - reach), camera.height);
  const int x1 = clip(std::ceil(high.x + reach) + 1, camera.width);
  const int y1 = clip(std::ceil(high.y + reach) + 1, camera.height);
  return {x0, y0, x1 - x0, y1 - y0};
}

MarkerGeometry GeometryOf(const SceneMarker& marker, const std::string& name) {
  try {
    return BuildMarkerGeometry(marker.design);
  } catch (const Error& error) {
    throw Error(error.code(), name + ": " + error.what());
  }
}

ProjectedMarker ProjectMarker(const Scene& scene, int index, double reach) {
  const TagProjector project(scene, index);
  const SceneMarker& marker = scene.markers[index];
  const MarkerGeometry geometry = GeometryOf(marker, project.name());
  ProjectedMarker result;
  double ground = marker.white;
  const auto paint = [&](const std::vector<Outline>& area, double level) {
    const int segments = area[0].radius > 0 ? project.CircleSegments(area[0]) : 0;
    Polygon outline = project.Outlined(TessellateUnion(area, segments));
    if (result.silhouette.empty()) {
      result.silhouette = std::move(outline);
      result.level = level;
    } else {
      result.inks.push_back({std::move(outline), level - ground});
    }
    ground = level;
  };
  if (!geometry.paper.empty()) paint(geometry.paper, marker.white);
  if (!geometry.frame.empty()) paint(geometry.frame, marker.black);
  paint({geometry.white}, marker.white);
  for (const auto& node : geometry.nodes) {
    ground = marker.white;
    paint(node, marker.black);
  }
  for (const Outline& hole : geometry.holes) {
    ground = marker.black;
    paint({hole}, marker.white);
  }
  result.bounds = TouchedPixels(result.silhouette, reach, scene.camera);
  return result;
}

/// A band of full rows of the frame, in grey levels.
struct Band {
  int y0;
  int width;
  int height;
  std::vector<double> values;
  double* row(int y) { return values.data() + static_cast<size_t>(y - y0) * width; }
};

void DrawMarker(const ProjectedMarker& marker, const PixelResponse& response, Band* band) {
  Rect area = marker.bounds;
  const int bottom = std::min(area.y + area.height, band->y0 + band->height);
  area.y = std::max(area.y, band->y0);
  area.height = bottom - area.y;
  if (area.width <= 0 || area.height <= 0) return;
  AreaRaster alpha(response, area), ink(response, area);
  alpha.Add(marker.silhouette, 1);
  for (const Ink& part : marker.inks) ink.Add(part.outline, part.level);
  alpha.Finish();
  ink.Finish();
  for (int y = area.y; y < area.y + area.height; ++y) {
    const double* a = alpha.row(y);
    const double* i = ink.row(y);
    double* out = band->row(y) + area.x;
    for (int x = 0; x < area.width; ++x) out[x] += a[x] * (marker.level - out[x]) + i[x];
  }
}

/// Resampling of one axis: a target pixel is a weighted sum of consecutive source pixels.
struct AxisTaps {
  std::vector<int> first;
  std::vector<std::vector<double>> weights;
};

// The source pixels under each target pixel, by area; between two source pixels linearly where
// the target is finer. `scale` is target pixels per source pixel, the centres coincide.
AxisTaps MakeTaps(int source, int target, double scale) {
  AxisTaps taps;
  taps.first.reserve(static_cast<size_t>(target));
  taps.weights.reserve(static_cast<size_t>(target));
  for (int i = 0; i < target; ++i) {
    const double center = (i - 0.5 * (target - 1)) / scale + 0.5 * (source - 1);
    const double half = std::max(0.5 / scale, 0.5);
    const int first = std::clamp(static_cast<int>(std::floor(center - half + 0.5)), 0, source - 1);
    const int last =
        std::clamp(static_cast<int>(std::ceil(center + half - 0.5)), first, source - 1);
    std::vector<double> weights;
    weights.reserve(static_cast<size_t>(last - first) + 1);
    double sum = 0;
    for (int s = first; s <= last; ++s) {
      const double overlap = std::min(center + half, s + 0.5) - std::max(center - half, s - 0.5);
      weights.push_back(std::max(overlap, 1e-12));
      sum += weights.back();
    }
    for (double& weight : weights) weight /= sum;
    taps.first.push_back(first);
    taps.weights.push_back(std::move(weights));
  }
  return taps;
}

/// The frame before any marker: one grey level, or an image scaled to cover the frame.
class Background {
 public:
  explicit Background(const Scene& scene)
      : level_(scene.background), image_(scene.background_image) {
    if (image_.data == nullptr) return;
    const double scale = std::max(static_cast<double>(scene.camera.width) / image_.width,
                                  static_cast<double>(scene.camera.height) / image_.height);
    columns_ = MakeTaps(image_.width, scene.camera.width, scale);
    rows_ = MakeTaps(image_.height, scene.camera.height, scale);
    blended_.resize(image_.width);
  }

  void Fill(Band* band) {
    band->values.assign(static_cast<size_t>(band->width) * band->height, level_);
    if (image_.data == nullptr) return;
    for (int y = band->y0; y < band->y0 + band->height; ++y) FillRow(y, band->row(y));
  }

 private:
  void FillRow(int y, double* out) {
    std::fill(blended_.begin(), blended_.end(), 0.0);
    const std::vector<double>& weights = rows_.weights[y];
    for (size_t k = 0; k < weights.size(); ++k) {
      const uint8_t* in = image_.row(rows_.first[y] + static_cast<int>(k));
      for (int x = 0; x < image_.width; ++x) blended_[x] += weights[k] * in[x];
    }
    for (size_t x = 0; x < columns_.first.size(); ++x) {
      out[x] = 0;
      for (size_t k = 0; k < columns_.weights[x].size(); ++k) {
        out[x] += columns_.weights[x][k] * blended_[columns_.first[x] + k];
      }
    }
  }

  double level_;
  ImageView image_;
  AxisTaps columns_, rows_;
  std::vector<double> blended_;  // source rows under one target row
};

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

Image RenderScene(const Scene& scene) {
  ValidateScene(scene);
  const PixelResponse response(scene.blur);
  std::vector<ProjectedMarker> markers;
  markers.reserve(scene.markers.size());
  for (int i = 0; i < static_cast<int>(scene.markers.size()); ++i) {
    markers.push_back(ProjectMarker(scene, i, response.reach()));
  }
  const int width = scene.camera.width, height = scene.camera.height;
  Image frame(width, height);
  Background background(scene);
  Noise noise(scene.seed, scene.noise);
  const int band_rows = std::max(1, kBandPixels / width);
  Band band{0, width, 0, {}};
  for (band.y0 = 0; band.y0 < height; band.y0 += band_rows) {
    band.height = std::min(band_rows, height - band.y0);
    background.Fill(&band);
    for (const ProjectedMarker& marker : markers) DrawMarker(marker, response, &band);
    for (int y = band.y0; y < band.y0 + band.height; ++y) {
      const double* in = band.row(y);
      uint8_t* out = frame.row(y);
      for (int x = 0; x < width; ++x) {
        const double value = scene.noise > 0 ? in[x] + noise.Next() : in[x];
        out[x] = static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
      }
    }
  }
  return frame;
}

Detection GroundTruth(const Scene& scene, int marker) {
  ValidateScene(scene);
  if (marker < 0 || marker >= static_cast<int>(scene.markers.size())) {
    FailArgument("marker " + std::to_string(marker) + " is not one of the scene's " +
                 std::to_string(scene.markers.size()));
  }
  const TagProjector project(scene, marker);
  const SceneMarker& truth = scene.markers[marker];
  Detection detection;
  detection.family = truth.design.family;
  detection.id = truth.design.id;
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
