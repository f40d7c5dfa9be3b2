// The options of the command detect for hard conditions: hidden nodes, IDs in use, noise, range and
// exact poses.
#include <gtest/gtest.h>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

class CliHardTest : public CliTest {
 protected:
  /// scene.png, cam.yaml: a 4x4 marker; `more` is the scene's other keys.
  void Render(const std::string& more, const std::string& distance = "0.2") const {
    WriteFile(folder_ / "scene.json", R"({
      "camera": {"width": 480, "height": 480, "fx": 600, "fy": 600, "cx": 240, "cy": 240},
      "background": 90, "blur": 0.7, "seed": 7, )" +
                                          more + R"(,
      "markers": [{"family": "4x4", "id": 278, "size": 0.05, "rvec": [0.3, 0.1, 0.3],
                   "t": [0, 0, )" + distance +
                                          "]}]}");
    const Outcome outcome = Run("render scene.json -o scene.png --write-camera cam.yaml");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  /// The only detection; null where there is none.
  Json Only(const std::string& arguments) const {
    const Json detections = Detect(arguments + " scene.png")["detections"];
    EXPECT_LE(detections.size(), 1u) << arguments;
    return detections.empty() ? Json(nullptr) : detections[0];
  }
};

// The last column of nodes is covered.
constexpr char kCover[] =
    R"("occluders": [{"marker": 0, "level": 12, "outline": [[4.9, -12], [12, -12], [12, 12], [4.9, 12]]}])";

TEST_F(CliHardTest, HiddenNodesAndIdsInUse) {
  Render(kCover);
  EXPECT_TRUE(Only("").is_null());
  const Json partial = Only("--hidden-nodes 4");
  ASSERT_FALSE(partial.is_null());
  EXPECT_EQ(partial["unknown_bits"], 0x1111);
  EXPECT_EQ(partial["id"], 278 & ~0x1111);
  const Json whole = Only("--hidden-nodes 4 --ids 4x4:278,100-103");
  ASSERT_FALSE(whole.is_null());
  EXPECT_EQ(whole["id"], 278);
  EXPECT_EQ(whole.count("unknown_bits"), 0u);
  EXPECT_TRUE(Only("--hidden-nodes 4 --ids 4x4:0").is_null());
}

TEST_F(CliHardTest, OthersThanTheIdsInUseAreLeftOut) {
  Render(R"("noise": 2)");
  EXPECT_EQ(Only("--ids 4x4:200-300")["id"], 278);
  EXPECT_EQ(Only("--ids 4x4:1 --ids 4x4:278")["id"], 278);
  EXPECT_EQ(Only("--ids 3x3:1")["id"], 278);
  EXPECT_TRUE(Only("--ids 4x4:0-277,279").is_null());
}

TEST_F(CliHardTest, PreBlurReadsSevereNoise) {
  Render(R"("noise": 60)");
  EXPECT_TRUE(Only("").is_null());
  EXPECT_EQ(Only("--pre-blur")["id"], 278);
}

TEST_F(CliHardTest, FarMarkersHaveAMargin) {
  Render(R"("noise": 2)", "1.6");
  EXPECT_TRUE(Only("").is_null());
  const Json marker = Only("--far on");
  ASSERT_FALSE(marker.is_null());
  EXPECT_EQ(marker["id"], 278);
  EXPECT_GT(marker["margin"].get<double>(), 0);
}

TEST_F(CliHardTest, PhotometricPoseSaysWhatItFound) {
  Render(R"("noise": 2)");
  const std::string poses = "--camera cam.yaml --tag-size 0.05 --pose ";
  EXPECT_EQ(Keys(Only(poses + "vertices")["pose"]),
            (Strings{"R", "t", "rms_px", "covariance", "alternative"}));
  const Json pose = Only(poses + "photometric")["pose"];
  EXPECT_EQ(Keys(pose),
            (Strings{"R", "t", "rms_px", "covariance", "alternative", "ambiguity", "photometric"}));
  const Json& found = pose["photometric"];
  EXPECT_NEAR(found["white"].get<double>(), 215, 5);
  EXPECT_NEAR(found["black"].get<double>(), 25, 5);
  EXPECT_GT(found["pixels"].get<int>(), 100);
}

TEST_F(CliHardTest, WrongValuesAreNamed) {
  Render(R"("noise": 2)");
  ExpectComplaint("detect --ids 4x4 scene.png", 2, {"--ids", "4x4"});
  ExpectComplaint("detect --ids 6x6:1 scene.png", 2, {"--ids", "6x6"});
  ExpectComplaint("detect --ids 4x4:99999 scene.png", 2, {"--ids", "99999"});
  ExpectComplaint("detect --hidden-nodes many scene.png", 2, {"--hidden-nodes", "many"});
  ExpectComplaint("detect --far perhaps scene.png", 2, {"--far", "perhaps"});
  ExpectComplaint("detect --pose quick scene.png", 2, {"--pose", "quick"});
}

}  // namespace
}  // namespace topotag
