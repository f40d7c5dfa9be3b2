// Object, polygon and scene files: whatever they hold, a value or an error of one line. The first
// byte says which kind of file the others are.

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "tests/fuzz/input.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/target.h"
#include "tools/scene_file.h"
#include "topotag/error.h"
#include "topotag/object.h"
#include "topotag/renderer.h"

namespace topotag::fuzz {
namespace {

constexpr char kObject = '0', kPolygon = '1', kScene = '2';

// Of frames that are rendered: larger ones take too long.
constexpr int kMaxPixels = 4096;
constexpr size_t kMaxMarkers = 3;

void RequireClose(double a, double b, const char* what) {
  Require(std::abs(a - b) <= 1e-9 * (1 + std::abs(a)), what);
}

void CheckObject(const std::string& path) {
  const Object object = ReadObject(path);
  ValidateObject(object);
  static const std::string copy =
      (std::filesystem::temp_directory_path() / ("fuzz_object_" + std::to_string(getpid())))
          .string();
  WriteObject(object, copy);
  const Object read = ReadObject(copy);
  std::filesystem::remove(copy);
  Require(read.markers.size() == object.markers.size(), "an object has lost markers");
  for (size_t i = 0; i < read.markers.size(); ++i) {
    const ObjectMarker &a = object.markers[i], &b = read.markers[i];
    Require(a.family == b.family && a.id == b.id, "an object has other markers");
    RequireClose(a.tag_size, b.tag_size, "an object has other sizes");
    for (size_t r = 0; r < 3; ++r) {
      RequireClose(a.t[r], b.t[r], "an object has other positions");
      for (size_t c = 0; c < 3; ++c) {
        RequireClose(a.R[r][c], b.R[r][c], "an object has other rotations");
      }
    }
  }
}

void CheckPolygon(const std::string& path) {
  MarkerDesign design;
  design.family = Family(3);
  design.outer = OuterShape::kPolygon;
  design.polygon = ReadPolygon(path);
  design.margin = 1;
  for (const InnerShape shape : {InnerShape::kSquare, InnerShape::kCircle}) {
    design.inner = shape;
    const MarkerGeometry geometry = BuildMarkerGeometry(design);
    Require(std::isfinite(geometry.min.x) && std::isfinite(geometry.min.y) &&
                std::isfinite(geometry.max.x) && std::isfinite(geometry.max.y),
            "a marker without bounds");
  }
}

bool IsSmall(const Scene& scene) {
  return int64_t{scene.camera.width} * scene.camera.height <= kMaxPixels &&
         scene.markers.size() <= kMaxMarkers && scene.occluders.size() <= kMaxMarkers &&
         scene.blur <= 3 && scene.exposure <= 0 && scene.row_time == 0;
}

void CheckScene(const std::string& path) {
  const tools::SceneFile file = tools::ReadScene(path);
  for (size_t i = 0; i < std::min(file.scene.markers.size(), kMaxMarkers); ++i) {
    GroundTruth(file.scene, static_cast<int>(i));
  }
  if (IsSmall(file.scene)) RenderScene(file.scene);
}

std::string SceneText(const std::string& marker, const std::string& rest) {
  return R"({"camera": {"width": 64, "height": 48, "fx": 60, "fy": 60, "cx": 31.5, "cy": 23.5,
 "distortion_model": "brown", "distortion": [-0.15, 0.05, 0, 0, 0]}, "background": 90, "blur": 0.7,
 "noise": 2, "seed": 1, "markers": [{"family": "4x4", "id": 278, "size": 0.05, )" +
         marker + R"("t": [0.0, -0.01, 0.1]}])" + rest + "}";
}

}  // namespace

std::vector<std::string> Seeds() {
  return {
      std::string(1, kObject) +
          "# board\n4x4 278 0.05 0 0 0 0 0 0\n3x3 5 0.04 0.1 -0.02 1e-3 "
          "0.5 -1.5707963 0.1 # second\n\n8x8 4611686018427387903 1 0 0 0 "
          "0 0 6.2831853\n",
      std::string(1, kObject) + "5x5 8388607 +0.5 1e3 -1e-5 .5 3.1415926 0 0\r\n",
      std::string(1, kPolygon) + "-8 -8\n8 -8\n8 8\n-8 8\n",
      std::string(1, kPolygon) + "# outline\n-9 -7.5\n0 -10\n9.25 -7\n8 8e0\n0 7\n-8 8\n-9 -7.5\n",
      std::string(1, kScene) +
          SceneText(
              R"("inner": "circle", "outer": "butterfly", "frame": 2, "rvec": [0.3, 0.5, 0],)",
              R"(, "occluders": [{"outline": [[1, 2], [20, 2], [9, 30]], "level": 200},
 {"outline": [[-4, -4], [4, -4], [0, 4]], "marker": 0}])"),
      std::string(1, kScene) +
          SceneText(R"("R": [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "growth": 0.1, "black": 10,)",
                    R"(, "lighting": {"gain": 1.2, "gradient": [0.01, 0], "vignetting": 0.2,
 "shadow": {"point": [30, 20], "angle": 0.5, "factor": 0.3, "penumbra": 4},
 "highlights": [{"center": [9, 9], "sigma": 5, "level": 100}]})"),
      std::string(1, kScene) +
          SceneText(R"("velocity": [0.1, 0, 0], "angular_velocity": [0, 1, 0], "white": 250,)",
                    R"(, "exposure": 0.01, "row_time": 1e-4)"),
      std::string(1, kScene) + R"({"camera": "camera.yaml", "background": "wall.png"})",
      std::string(1, kScene) + R"({"camera": {"wi\ndth": 64}})"};
}

}  // namespace topotag::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace topotag;
  static fuzz::MemoryFile file;
  fuzz::Input input(data, size);
  const char kind = static_cast<char>(input.Byte());
  file.Set(input.Rest());
  try {
    if (kind == fuzz::kObject) fuzz::CheckObject(file.path());
    if (kind == fuzz::kPolygon) fuzz::CheckPolygon(file.path());
    if (kind == fuzz::kScene) fuzz::CheckScene(file.path());
  } catch (const Error& error) {
    fuzz::RequireOneLine(error.what());
  }
  return 0;
}
