// Camera files: whatever they hold, a camera or an error of one line; what was read is written and
// read back the same; points are projected and unprojected by every camera that a file can state.

#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/target.h"
#include "topotag/camera_file.h"
#include "topotag/error.h"

namespace topotag::fuzz {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<double, 10> kCoordinates{0,   0.25,  -1,    1e-300,    639.5,
                                              1e9, -1e30, 1e308, kInfinity, kNan};

bool IsSame(const Camera& a, const Camera& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy && a.model == b.model && a.distortion == b.distortion;
}

// Of a camera whose lens has no coefficient but zeros, the model is not written.
bool IsPlain(const Camera& camera) {
  return camera.model != DistortionModel::kFisheye && camera.distortion == std::array<double, 14>{};
}

void CheckPoint(const Camera& camera, Point2 point) {
  Jacobian2 jacobian;
  Project(camera, point, &jacobian);
  const Point2 untouched{-7, 7};
  Point2 normalized = untouched;
  if (!Unproject(camera, point, &normalized)) {
    Require(normalized == untouched, "a point was changed that cannot be unprojected");
    return;
  }
  Require(std::isfinite(normalized.x) && std::isfinite(normalized.y), "unprojected to no point");
  Require(std::isfinite(point.x) && std::isfinite(point.y), "unprojected from no point");
  Project(camera, normalized, &jacobian);
}

void CheckPoints(const Camera& camera) {
  for (const double x : kCoordinates) {
    for (const double y : kCoordinates) CheckPoint(camera, {x, y});
  }
  for (const double u : {-0.5, 0.0, 0.3, 1.0, 1.5}) {
    for (const double v : {-0.5, 0.1, 0.5, 1.0}) {
      CheckPoint(camera, {u * camera.width, v * camera.height});
      CheckPoint(camera, {camera.cx + u * camera.fx, camera.cy + v * camera.fy});
    }
  }
}

void CheckRoundTrip(const Camera& camera) {
  static const std::string path =
      (std::filesystem::temp_directory_path() / ("fuzz_camera_" + std::to_string(getpid())))
          .string();
  WriteCamera(camera, path);
  Camera read = ReadCamera(path);
  std::filesystem::remove(path);
  if (IsPlain(camera)) read.model = camera.model;
  Require(IsSame(camera, read), "a camera is not read as it was written");
}

}  // namespace

std::vector<std::string> Seeds() {
  const std::string matrix = "[700.5, 0, 319.5, 0, 701, 239.5, 0, 0, 1]";
  const std::string size = "image_width: 640\nimage_height: 480\n";
  std::vector<std::string> seeds;
  for (const char* d : {"", "-0.1, 0.01, 1e-3, -2e-3", "-0.3, 0.1, 0, 0, -0.02",
                        "0.1, 0.2, 0, 0, 0.01, 0.2, 0.1, 0.01",
                        "0.1, 0.2, 0, 0, 0, 0, 0, 0, 1e-3, 1e-4, 2e-3, 2e-4",
                        "0.1, 0.2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.02, -0.03"}) {
    const std::string data = std::string("[") + d + "]";
    seeds.push_back(size + "camera_matrix: " + matrix + "\ndistortion_coefficients: " + data +
                    "\n");
    seeds.push_back("{\"image_width\": 640, \"image_height\": 480, \"camera_matrix\": " + matrix +
                    ", \"distortion_coefficients\": " + data + "}");
  }
  seeds.push_back("%YAML:1.0\n---\n" + size +
                  "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: " +
                  matrix + "\ndistortion_coefficients: !!opencv-matrix\n" +
                  "   rows: 1\n   cols: 4\n   dt: d\n   data: [ -0.1, 0.01, 0., 0. ]\n");
  seeds.push_back("camera_name: narrow\n" + size +
                  "camera_matrix:\n  rows: 3\n  cols: 3\n  data: " + matrix +
                  "\ndistortion_model: equidistant\ndistortion_coefficients:\n" +
                  "  rows: 1\n  cols: 4\n  data: [0.05, -0.01, 0.002, -1e-4]\n");
  // The limits of what a camera may be.
  seeds.push_back(
      "camera_matrix: [1e9, 0, -1e9, 0, 1e-9, 1e9, 0, 0, 1]\n"
      "distortion_coefficients: [-0.3, 1e300, 0, 0]\n");
  seeds.push_back(
      "cameraMatrix: [[700, 0, 320], [0, 700, 240], [0, 0, 1]]\n"
      "distortionCoefficients: [+0.1, -.2, 1e-3, 0]\n");
  return seeds;
}

}  // namespace topotag::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace topotag;
  static fuzz::MemoryFile file;
  file.Set(data, size);
  try {
    const Camera camera = ReadCamera(file.path());
    fuzz::CheckPoints(camera);
    fuzz::CheckRoundTrip(camera);
  } catch (const Error& error) {
    fuzz::RequireOneLine(error.what());
  }
  return 0;
}
