// Every allocation fails while files are read and written: std::bad_alloc or an Error, and no file
// is there under its name that is not complete.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/failing_allocations.h"
#include "tests/temporary_folder.h"
#include "topotag/camera_file.h"
#include "topotag/generator.h"
#include "topotag/image_file.h"
#include "topotag/object.h"

// OpenCV leaves behind what its image libraries have when its own memory runs out.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libopencv_\nleak:libpng16.so\nleak:libjpeg.so\nleak:libtiff.so\nleak:libwebp.so\n";
}

namespace topotag {
namespace {

namespace fs = std::filesystem;

class FaultAllocationIoTest : public testing::Test {
 protected:
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string ReadFile(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  // With an old file in the way and without one: it is replaced as a whole, or not at all.
  template <typename Write>
  void FailWriting(const std::string& name, const Write& write) {
    const std::string path = Path(name);
    write(path);
    const std::string whole = ReadFile(path);
    EXPECT_NE(whole, "");
    for (const bool is_old_there : {true, false}) {
      const auto make = [&] {
        fs::remove(path);
        if (is_old_there) std::ofstream(path) << "old";
        return test::Nothing();
      };
      test::FailEachAllocation(
          make, [&](test::Nothing*) { write(path); },
          [&](test::Nothing*) {
            const std::string bytes = ReadFile(path);
            EXPECT_TRUE(bytes == whole || bytes == (is_old_there ? "old" : "")) << path;
            size_t files = 0;
            for (const auto& entry : fs::directory_iterator(folder_))
              files += !entry.path().empty();
            EXPECT_EQ(files, fs::exists(path) ? 1u : 0u) << "and no temporary file";
          });
    }
    fs::remove(path);
  }

  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

TEST_F(FaultAllocationIoTest, Cameras) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 500;
  camera.model = DistortionModel::kBrown;
  camera.distortion[0] = -0.1;
  FailWriting("camera.yaml", [&](const std::string& path) { WriteCamera(camera, path); });
  WriteCamera(camera, Path("camera.yaml"));
  test::FailEachAllocation([&] { ReadCamera(Path("camera.yaml")); });
}

TEST_F(FaultAllocationIoTest, Objects) {
  const Object board = MakeGrid(Family(4), 0, 1, 3, 0.04, 0.06);
  FailWriting("board.txt", [&](const std::string& path) { WriteObject(board, path); });
  WriteObject(board, Path("board.txt"));
  test::FailEachAllocation([&] { ReadObject(Path("board.txt")); });
}

TEST_F(FaultAllocationIoTest, Polygons) {
  std::ofstream(Path("polygon.txt")) << "# a triangle\n-30 -20\n30 -20\n0 50\n";
  test::FailEachAllocation([&] { ReadPolygon(Path("polygon.txt")); });
  MarkerDesign design;
  design.outer = OuterShape::kPolygon;
  design.polygon = ReadPolygon(Path("polygon.txt"));
  design.margin = 1;
  test::FailEachAllocation([&] { BuildMarkerGeometry(design); });
}

TEST_F(FaultAllocationIoTest, Images) {
  Image image(40, 30);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) image.row(y)[x] = static_cast<uint8_t>(x * y);
  }
  for (const std::string extension : {"png", "jpg", "bmp", "pgm", "tif", "webp"}) {
    const std::string name = "image." + extension;
    // OpenCV's own writer of TIFF files ends the process where it has no memory.
    if (extension != "tif")
      FailWriting(name, [&](const std::string& path) { WriteImage(image.view(), path); });
    WriteImage(image.view(), Path(name));
    test::FailEachAllocation([&] { ReadImage(Path(name)); });
    fs::remove(Path(name));
  }
}

TEST_F(FaultAllocationIoTest, Markers) {
  MarkerDesign design;
  design.family = Family(3);
  design.inner = InnerShape::kCircle;
  design.margin = 1;
  PrintOptions print;
  print.size_mm = 20;
  print.dpi = 72;
  for (const std::string extension : {"png", "svg", "pdf"}) {
    FailWriting("marker." + extension,
                [&](const std::string& path) { WriteMarker(design, print, path); });
    FailWriting("sheet." + extension, [&](const std::string& path) {
      WriteSheet({design, design}, print, {}, path);
    });
  }
}

}  // namespace
}  // namespace topotag
