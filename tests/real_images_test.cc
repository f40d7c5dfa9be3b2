// Photographs of other people, read from a folder beside the checkout where there is one.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/scene_util.h"
#include "topotag/detector.h"
#include "topotag/image_file.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;

fs::path DataFolder() { return fs::path(TOPOTAG_SOURCE_DIR).parent_path() / "shared" / "data"; }

#define TOPOTAG_REQUIRE_DATA(folder)                                   \
  if (!fs::is_directory(DataFolder() / (folder))) {                    \
    GTEST_SKIP() << "no photographs in " << (DataFolder() / (folder)); \
  }                                                                    \
  static_assert(true, "")

nlohmann::json Labels() {
  std::ifstream file(DataFolder() / "topotag_real" / "labels.json");
  return nlohmann::json::parse(file);
}

using Markers = std::multiset<std::pair<int, uint64_t>>;

Markers Labelled(const nlohmann::json& image) {
  Markers markers;
  for (const auto& marker : image["markers"]) {
    markers.emplace(marker["n"].get<int>(), marker["id"].get<uint64_t>());
  }
  return markers;
}

Markers Found(const std::vector<Detection>& detections) {
  Markers markers;
  for (const Detection& d : detections) markers.emplace(d.family.n(), d.id);
  return markers;
}

TEST(RealImagesTest, EveryMarkerOfThePhotographsAndNoOther) {
  TOPOTAG_REQUIRE_DATA("topotag_real");
  Options options;
  options.far = true;  // the right face of the cube is 30 px wide
  options.inverted = true;
  Detector detector(options);
  int images = 0;
  int found_markers = 0;
  const nlohmann::json labels = Labels();
  for (const auto& image : labels["images"]) {
    if (image.value("annotated", false) || image.value("rendered", false)) continue;
    const std::string name = image["file"];
    const Image pixels = ReadImage((DataFolder() / "topotag_real" / name).string());
    const std::vector<Detection> detections = detector.detect(pixels.view());
    for (const Detection& detection : detections) EXPECT_FALSE(detection.inverted) << name;
    const Markers found = Found(detections);
    const Markers expected = Labelled(image);
    for (const auto& marker : found) EXPECT_EQ(expected.count(marker), 1u) << name;
    for (const auto& marker : expected) {
      EXPECT_EQ(found.count(marker), 1u) << name << ": " << marker.second << " not found";
      found_markers += static_cast<int>(found.count(marker));
    }
    ++images;
  }
  EXPECT_EQ(images, 13);
  EXPECT_EQ(found_markers, 18);
  std::cout << found_markers << " markers in " << images << " photographs\n";
}

Camera OfficialCamera(const nlohmann::json& image) {
  const auto& matrix = image["camera"]["camera_matrix"];
  Camera camera;
  camera.fx = matrix[0];
  camera.cx = matrix[2];
  camera.fy = matrix[4];
  camera.cy = matrix[5];
  camera.model = DistortionModel::kBrown;
  const auto& distortion = image["camera"]["distortion_coefficients"];
  for (size_t i = 0; i < distortion.size(); ++i) camera.distortion[i] = distortion[i];
  return camera;
}

Matrix3 FromQuaternion(const nlohmann::json& q) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
           {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
           {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}};
}

TEST(RealImagesTest, PosesOfTheOfficialSample) {
  TOPOTAG_REQUIRE_DATA("topotag_real");
  const nlohmann::json labels = Labels();
  for (const auto& image : labels["images"]) {
    if (image["file"] != "official_3x3_circle.png") continue;
    Options options;
    options.camera = OfficialCamera(image);
    options.tag_size = image["white_side_m"];
    Detector detector(options);
    const Image pixels = ReadImage((DataFolder() / "topotag_real" / image["file"]).string());
    std::vector<Detection> found;
    for (int warm = 0; warm < 20; ++warm) found = detector.detect(pixels.view());
    const StageTimes& t = detector.times();
    std::cout << "stages, us: threshold " << t.threshold << " binarize " << t.binarize << " label "
              << t.label << " tree " << t.tree << " decode " << t.decode << " vertices "
              << t.vertices << " pose " << t.pose << " total " << t.total << "\n";
    ASSERT_EQ(found.size(), 2u);
    for (const auto& marker : image["markers"]) {
      const Detection& d = found[marker["id"] == 46 ? 1 : 0];
      EXPECT_EQ(d.id, marker["id"].get<uint64_t>());
      ASSERT_TRUE(d.pose);
      const auto& pose = marker["official_library_pose"];
      const Vector3 t{pose["t"][0], pose["t"][1], pose["t"][2]};
      const double position = test::Distance(d.pose->t, t) / test::Norm(t);
      const double rotation = test::AngleBetween(d.pose->R, FromQuaternion(pose["q_xyzw"]));
      std::cout << "ID " << d.id << ": position differs by " << 100 * position
                << " % of the distance, rotation by " << rotation << " degrees, rms "
                << d.pose->rms_px << " px\n";
      EXPECT_LT(position, 0.01);
      EXPECT_LT(rotation, 1.5);
    }
  }
}

class NegativeImagesTest : public testing::TestWithParam<const char*> {};

TEST_P(NegativeImagesTest, NoDetection) {
  TOPOTAG_REQUIRE_DATA(GetParam());
  Options options;
  options.families = Family::ParseList("3x3,4x4,5x5,6x6,7x7,8x8");
  options.far = true;
  options.inverted = true;
  Detector detector(options);
  options.preset = Preset::kPaper;
  Detector paper(options);
  const std::vector<std::string> files = ListImages((DataFolder() / GetParam()).string());
  for (const std::string& file : files) {
    const Image image = ReadImage(file);
    EXPECT_TRUE(detector.detect(image.view()).empty()) << file;
    EXPECT_TRUE(paper.detect(image.view()).empty()) << file;
  }
  EXPECT_GT(files.size(), 20u);
  std::cout << files.size() << " images\n";
}

INSTANTIATE_TEST_SUITE_P(Folders, NegativeImagesTest,
                         testing::Values("natural", "hard_negative", "peer_tags"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace topotag
