// The options of the command detect that say which markers are wanted, how large they are, and what
// is told of them.
#include <gtest/gtest.h>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

class CliOptionsTest : public CliTest {
 protected:
  Json Markers(const std::string& arguments) const {
    return Detect(arguments + " scene.png")["detections"];
  }
};

TEST_F(CliOptionsTest, SizesOfFamiliesAndIds) {
  RenderScene();
  const auto distance = [&](const std::string& sizes, int id) {
    for (const Json& marker : Markers("--camera cam.yaml " + sizes)) {
      if (marker["id"] == id) return marker["pose"].is_null() ? 0 : double(marker["pose"]["t"][2]);
    }
    return -1.0;
  };
  // 3x3 ID 46 and 4x4 ID 278 are at 0.25 m, 3x3 ID 1 is at 0.3 m, all with a size of 0.05 m.
  const std::string sizes = "--tag-size 0.05,3x3=0.1,3x3:0-1,7=0.025";
  EXPECT_NEAR(distance(sizes, 278), 0.25, 0.002);
  EXPECT_NEAR(distance(sizes, 46), 0.5, 0.004);
  EXPECT_NEAR(distance(sizes, 1), 0.15, 0.002);
  EXPECT_NEAR(distance("--tag-size 3x3:1=0.1 --tag-size 0.05", 1), 0.6, 0.005);
  EXPECT_NEAR(distance("--tag-size 3x3:1=0.1 --tag-size 0.05", 46), 0.25, 0.002);
  EXPECT_EQ(distance("--tag-size 4x4=0.05", 46), 0);
  EXPECT_NEAR(distance("--tag-size 4x4=0.05", 278), 0.25, 0.002);
}

TEST_F(CliOptionsTest, SizesThatAreWrong) {
  RenderScene();
  const std::pair<const char*, Strings> cases[] = {
      {"nan", {"'nan' is not a finite number"}},
      {"3x3=nan", {"'nan' is not a finite number"}},
      {"0.05,3x3=0", {"0 is not greater than 0"}},
      {"0.05,", {"'' is not a finite number"}},
      {"3x3=", {"'' is not a finite number"}},
      {"0.05,0.06", {"the size of all markers is given twice"}},
      {"3x3=0.05,3x3=0.05", {"the size of 3x3 is given twice"}},
      {"4x4:1,5-7=0.1,4x4:6=0.2", {"the size of 4x4 ID 6 is given twice"}},
      {"6x6=0.1", {"6x6", "--family"}},
      {"9x9=0.1", {"9x9"}},
      {"=0.1", {"''"}},
      {"3x3:128=0.1", {"128", "127"}},
      {"3x3:9-5=0.1", {"9-5"}},
      {"3x3:=0.1", {"''"}},
      {"0.05,3x3:1,2", {"'3x3:1,2' is not FAMILY:LIST=METRES"}},
      {"3x3:1", {"'3x3:1' is not FAMILY:LIST=METRES"}},
      {"1e-320", {"tag size", "1e-09 .. 1e+06 metres"}},
      {"3x3=1e7", {"tag size of family 3x3"}}};
  for (const auto& [value, parts] : cases) {
    ExpectComplaint(std::string("detect --tag-size '") + value + "' scene.png", 2, parts);
  }
  ExpectComplaint("detect --tag-size 0.1 --tag-size 0.2 scene.png", 2, {"--tag-size", "twice"});
}

TEST_F(CliOptionsTest, MinSize) {
  RenderScene();
  EXPECT_EQ(Markers("").size(), 3u);
  EXPECT_EQ(Markers("--min-size 50").size(), 3u);
  EXPECT_EQ(Markers("--min-size 105").size(), 2u);  // the third one is 100 px wide
  EXPECT_EQ(Markers("--min-size 200").size(), 0u);
  ExpectComplaint("detect --min-size -1 scene.png", 2, {"--min-size", "-1"});
  ExpectComplaint("detect --min-size nan scene.png", 2, {"--min-size", "nan"});
  ExpectComplaint("detect --min-size 1e9 scene.png", 2, {"minimum size"});
}

TEST_F(CliOptionsTest, Quality) {
  RenderScene();
  const Strings plain = Keys(Markers("")[0]);
  EXPECT_EQ(std::count(plain.begin(), plain.end(), "quality"), 0);
  EXPECT_EQ(Keys(Markers("--quality off")[0]), plain);
  for (const Json& marker : Markers("--quality on")) {
    const Json& quality = marker["quality"];
    EXPECT_EQ(Keys(quality), (Strings{"contrast", "decision", "sharpness", "rms_px"}));
    EXPECT_NEAR(quality["contrast"].get<double>(), 190, 20);
    EXPECT_GT(quality["decision"].get<double>(), 0.7);
    EXPECT_LE(quality["decision"].get<double>(), 1);
    EXPECT_LT(quality["rms_px"].get<double>(), 0.1);
  }
  EXPECT_NE(Run("detect --quality on scene.png").out.find("decision 0."), std::string::npos);
  const Strings csv = Lines(Run("detect --quality on --inverted --format csv scene.png").out);
  ASSERT_EQ(csv.size(), 4u);
  EXPECT_NE(csv[0].find(",rms_px,inverted,contrast,decision,sharpness,fit_px"), std::string::npos);
  for (const std::string& line : csv) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 31) << line;
  }
  ExpectComplaint("detect --quality yes scene.png", 2, {"--quality", "yes"});
}

// From the printed marker and from a scene.
TEST_F(CliOptionsTest, Inverted) {
  EXPECT_EQ(
      Run("generate --family 4x4 --id 278 --margin 2 --dpi 100 --inverted -o scene.png").status, 0);
  EXPECT_EQ(Markers("").size(), 0u);
  Json found = Markers("--inverted");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0]["id"], 278);
  EXPECT_EQ(found[0]["inverted"], true);
  EXPECT_NE(Run("detect --inverted scene.png").out.find("px  inverted"), std::string::npos);

  EXPECT_EQ(Run("generate --family 4x4 --id 278 --margin 2 --dpi 100 -o scene.png").status, 0);
  found = Markers("--inverted");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].count("inverted"), 0u);

  WriteFile(folder_ / "scene.json", R"({
    "camera": {"width": 400, "height": 300, "fx": 500, "fy": 500, "cx": 200, "cy": 150},
    "markers": [{"family": "3x3", "id": 7, "size": 0.05, "inverted": true, "t": [0.04, 0, 0.25]},
                {"family": "3x3", "id": 8, "size": 0.05, "inverted": false, "t": [-0.04, 0, 0.25]}]})");
  ASSERT_EQ(Run("render scene.json -o scene.png --truth truth.json").status, 0);
  const Json truth = Json::parse(ReadFile(folder_ / "truth.json"))["detections"];
  found = Markers("--inverted");
  ASSERT_EQ(found.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(found[i].count("inverted"), found[i]["id"] == 7 ? 1u : 0u);
    EXPECT_EQ(truth[i].count("inverted"), truth[i]["id"] == 7 ? 1u : 0u);
  }
  WriteFile(folder_ / "bad.json", R"({
    "camera": {"width": 400, "height": 300, "fx": 500, "fy": 500, "cx": 200, "cy": 150},
    "markers": [{"family": "3x3", "id": 7, "size": 0.05, "inverted": 1, "t": [0, 0, 0.25]}]})");
  ExpectComplaint("render bad.json -o scene.png", 1, {"bad.json: marker 0: inverted"});
}

}  // namespace
}  // namespace topotag
