// Detects a marker in a plain buffer, with nothing but the installed core library.

#include <topotag/detector.h>
#include <topotag/renderer.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace {

constexpr uint64_t kId = 278;

topotag::Camera MakeCamera() {
  topotag::Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 600;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
}

topotag::Scene MakeScene() {
  topotag::SceneMarker marker;
  marker.design.family = topotag::Family(4);
  marker.design.id = kId;
  marker.tag_size = 0.05;
  marker.t = {0.01, -0.02, 0.2};
  topotag::Scene scene;
  scene.camera = MakeCamera();
  scene.markers.push_back(marker);
  return scene;
}

}  // namespace

int main() {
  const topotag::Image frame = topotag::RenderScene(MakeScene());
  std::vector<uint8_t> pixels(static_cast<size_t>(frame.width()) * frame.height());
  for (int y = 0; y < frame.height(); ++y) {
    std::copy_n(frame.row(y), frame.width(),
                pixels.begin() + static_cast<ptrdiff_t>(y) * frame.width());
  }

  topotag::Options options;
  options.camera = MakeCamera();
  options.tag_size = 0.05;
  topotag::Detector detector(options);
  const std::vector<topotag::Detection> found =
      detector.detect({pixels.data(), frame.width(), frame.height(), frame.width()});

  if (found.size() != 1 || found[0].id != kId || !found[0].pose) {
    std::fprintf(stderr, "%zu markers found, expected one: 4x4 ID 278 with its pose\n",
                 found.size());
    return 1;
  }
  std::printf("topotag %s: %s ID %llu at %.3f m\n", topotag::Version(),
              found[0].family.name().c_str(), static_cast<unsigned long long>(found[0].id),
              found[0].pose->t[2]);
  return 0;
}
