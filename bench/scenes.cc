#include "bench/scenes.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "tests/scene_util.h"

namespace topotag::bench {
namespace {

constexpr double kDistance = 0.4;       // metres
constexpr double kPitch = 0.09;         // of the rows and columns of markers, metres
constexpr double kCrowdDistance = 0.8;  // metres
constexpr double kCrowdShare = 0.96;    // of the frame; a marker at its border is not found
constexpr int kCrowdColumns = 16;
constexpr int kCrowdRows = 13;
constexpr double kMaxTilt = 40 * test::kDegree;

Camera CameraFor(FrameSize size) {
  return test::PinholeCamera(size.width, size.height, 695.0 / 1280 * size.width);
}

SceneMarker RandomMarker(const Vector3& t, test::Random* random) {
  using test::operator*;
  SceneMarker marker;
  marker.design.id = random->Below(marker.design.family.size());
  marker.R = LineOfSight(t) * random->Tilted(random->Uniform(0, kMaxTilt));
  marker.t = t;
  return marker;
}

double MinSide(const Camera& camera, double distance) {
  return camera.fx * OuterSide(SceneMarker()) / distance * std::cos(kMaxTilt);
}

/// Rows of five around the optical axis.
void AddMarkers(int count, Scene* scene) {
  test::Random random(1);
  const int columns = std::min(count, 5), rows = (count + columns - 1) / columns;
  for (int i = 0; i < count; ++i) {
    const int column = i % columns, row = i / columns;
    const double x = (column - (columns - 1) / 2.0) * kPitch;
    const double y = (row - (rows - 1) / 2.0) * kPitch;
    scene->markers.push_back(RandomMarker({x, y, kDistance}, &random));
  }
}

/// A photograph scaled to cover the frame.
Image Cover(const Image& photo, const Camera& camera) {
  Scene scene;
  scene.camera = camera;
  scene.background_image = photo.view();
  scene.noise = 0;
  return RenderScene(scene);
}

Image RandomBytes(int width, int height) {
  test::Random random(1);
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.row(y)[x] = static_cast<uint8_t>(random.Below(256));
  }
  return image;
}

}  // namespace

const char* Name(SceneKind kind) {
  switch (kind) {
    case SceneKind::kOneMarker:
      return "1_marker";
    case SceneKind::kMarkers:
      return "20_markers";
    case SceneKind::kPhoto:
      return "20_markers_photo";
    case SceneKind::kMosaic:
      return "20_markers_mosaic";
    default:
      return "noise";
  }
}

const char* Title(SceneKind kind) {
  switch (kind) {
    case SceneKind::kOneMarker:
      return "1 marker on a wall";
    case SceneKind::kMarkers:
      return "20 markers on a wall";
    case SceneKind::kPhoto:
      return "20 markers on a photo";
    case SceneKind::kMosaic:
      return "20 markers on a mosaic";
    default:
      return "pure noise";
  }
}

std::string Name(FrameSize size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

BenchScene MakeScene(SceneKind kind, FrameSize size, const Photos& photos) {
  BenchScene made;
  Scene& scene = made.scene;
  scene.camera = CameraFor(size);
  made.min_side = MinSide(scene.camera, kDistance);
  made.random = kind == SceneKind::kNoise;
  if (made.random) return made;
  if (kind == SceneKind::kPhoto) made.backdrop = Cover(TypicalPhoto(photos), scene.camera);
  if (kind == SceneKind::kMosaic) made.backdrop = Mosaic(photos, size.width, size.height);
  if (!made.backdrop.empty()) scene.background_image = made.backdrop.view();
  AddMarkers(kind == SceneKind::kOneMarker ? 1 : 20, &scene);
  return made;
}

BenchScene MakeCrowd(int count) {
  BenchScene made;
  Scene& scene = made.scene;
  scene.camera = CameraFor({1280, 960});
  made.min_side = MinSide(scene.camera, kCrowdDistance);
  const double width = scene.camera.width / scene.camera.fx * kCrowdShare * kCrowdDistance;
  const double height = scene.camera.height / scene.camera.fy * kCrowdShare * kCrowdDistance;
  test::Random random(2);
  for (int i = 0; i < kCrowdColumns * kCrowdRows; ++i) {
    const int column = i % kCrowdColumns, row = i / kCrowdColumns;
    const double x = (column + 0.5) / kCrowdColumns - 0.5;
    const double y = (row + 0.5) / kCrowdRows - 0.5;
    scene.markers.push_back(RandomMarker({x * width, y * height, kCrowdDistance}, &random));
  }
  for (size_t i = scene.markers.size() - 1; i > 0; --i) {
    std::swap(scene.markers[i], scene.markers[random.Below(i + 1)]);
  }
  scene.markers.resize(static_cast<size_t>(count));
  return made;
}

double OuterSide(const SceneMarker& marker) {
  const double white = marker.design.family.white_side();
  return marker.tag_size * (white + 2 * marker.design.frame) / white;
}

Matrix3 LineOfSight(const Vector3& t) {
  using test::operator*;
  const double around = std::atan2(t[0], -t[1]);
  const double away = std::atan2(std::hypot(t[0], t[1]), t[2]);
  return test::RotationZ(around) * (test::RotationX(away) * test::RotationZ(-around));
}

Image RenderTopoTags(const BenchScene& scene) {
  const Camera& camera = scene.scene.camera;
  return scene.random ? RandomBytes(camera.width, camera.height) : RenderScene(scene.scene);
}

Options SceneOptions(const BenchScene& scene) {
  Options options;
  options.camera = scene.scene.camera;
  options.tag_size = SceneMarker().tag_size;
  options.threads = 1;
  return options;
}

ColdFrames::ColdFrames(const ImageView& frame, size_t bytes) {
  const size_t frame_bytes = static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height);
  const size_t count = bytes / frame_bytes + 1;
  for (size_t i = 0; i < count; ++i) {
    Image copy(frame.width, frame.height);
    for (int y = 0; y < frame.height; ++y) {
      std::memcpy(copy.row(y), frame.row(y), static_cast<size_t>(frame.width));
    }
    views_.push_back(copy.view());
    copies_.push_back(std::move(copy));
  }
}

size_t ColdBytes() {
  constexpr int64_t kMiB = 1 << 20;
  int64_t cache = 0;
#ifdef _SC_LEVEL3_CACHE_SIZE
  cache = sysconf(_SC_LEVEL3_CACHE_SIZE);
#endif
  return static_cast<size_t>(std::clamp(cache * 5 / 4, 64 * kMiB, 512 * kMiB));
}

}  // namespace topotag::bench
