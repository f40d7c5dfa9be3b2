// The JSON of the command line is the same on every backend and thread count, but for its name and
// the times.

#include <gtest/gtest.h>

#include <iostream>
#include <string>
#include <vector>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

class CliParityTest : public CliTest {
 protected:
  // Lines of frames, as they were printed, without the backend and the times.
  Strings Frames(const std::string& arguments, const std::string& backend) const {
    const Outcome outcome = Run("detect --format json " + arguments + " --backend " + backend);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    Strings frames = Lines(outcome.out);
    for (std::string& frame : frames) {
      Json json = Json::parse(frame);
      EXPECT_EQ(json["backend"].get<std::string>().substr(0, backend.size()), backend);
      const size_t begin = frame.find("\"backend\""), end = frame.find("\"detections\"");
      const size_t times = frame.find("\"time_us\"");
      EXPECT_LT(begin, end);
      EXPECT_LT(end, times);
      frame = frame.substr(0, begin) + frame.substr(end, times - end);
    }
    return frames;
  }

  bool HasOpenCl() const {
    const Outcome outcome = Run("detect --backend opencl scene.png");
    if (outcome.status == 0) return true;
    std::cout << "without opencl: " << outcome.err;
    return false;
  }

  // Returns how many markers there are.
  size_t ExpectSame(const std::string& arguments) const {
    const Strings expected = Frames(arguments, "scalar");
    std::vector<std::string> backends{"simd"};
    if (HasOpenCl()) backends.push_back("opencl");
    for (const std::string& backend : backends) {
      for (int threads = 1; threads <= 4; ++threads) {
        const Strings frames = Frames(arguments + " --threads " + std::to_string(threads), backend);
        EXPECT_EQ(frames.size(), expected.size()) << backend;
        for (size_t i = 0; i < std::min(frames.size(), expected.size()); ++i) {
          EXPECT_EQ(frames[i], expected[i]) << backend << ", " << threads << " threads";
        }
      }
    }
    size_t markers = 0;
    for (const std::string& frame : expected) {
      for (size_t at = 0; (at = frame.find("\"id\"", at)) != std::string::npos; ++at) ++markers;
    }
    return markers;
  }
};

TEST_F(CliParityTest, RenderedScene) {
  RenderScene();
  EXPECT_EQ(ExpectSame("scene.png"), 3u);
  EXPECT_EQ(ExpectSame("--camera cam.yaml --tag-size 0.05 scene.png"), 3u);
  EXPECT_EQ(ExpectSame("--preset paper --camera cam.yaml --tag-size 0.05 scene.png"), 3u);
}

TEST_F(CliParityTest, Photographs) {
  RenderScene();
  const fs::path data = fs::path(TOPOTAG_SOURCE_DIR).parent_path() / "shared" / "data";
  if (!fs::is_directory(data)) GTEST_SKIP() << "no photographs in " << data;
  WriteFile(folder_ / "lens.yaml",
            "camera_matrix: {rows: 3, cols: 3, data: [900, 0, 320, 0, 900, 240, 0, 0, 1]}\n"
            "distortion_coefficients: {rows: 1, cols: 5, data: [-0.1, 0.01, 0, 0, 0]}\n");
  const std::string markers = " '" + (data / "topotag_real").string() + "'";
  EXPECT_GE(ExpectSame("--camera lens.yaml --tag-size 0.05" + markers), 5u);
  EXPECT_GE(ExpectSame("--preset paper" + markers), 5u);
  for (const char* folder : {"hard_negative", "peer_tags"}) {
    ExpectSame("--family 3x3,4x4,5x5,6x6,7x7,8x8 '" + (data / folder).string() + "'");
  }
}

}  // namespace
}  // namespace topotag
