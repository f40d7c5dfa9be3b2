// Detection::quality: it follows what is done to a frame.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "tests/scene_util.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

Scene TwelveMarkers(double pitch) {
  test::Random random(3);
  Scene scene;
  scene.camera = test::PinholeCamera(800, 600, 900);
  for (int i = 0; i < 12; ++i) {
    SceneMarker marker;
    marker.design.family = Family(3 + i % 3);
    marker.design.id = random.Below(marker.design.family.size());
    const double z =
        test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size, pitch);
    marker.R = random.Tilted(20 * test::kDegree);
    marker.t = {(i % 4 - 1.5) * 190 * z / 900, (i / 4 - 1) * 190 * z / 900, z};
    scene.markers.push_back(marker);
  }
  return scene;
}

// Means over all markers, which must all be found, each score in its range.
Quality MeanQuality(const Scene& scene) {
  const std::vector<Detection> found = Detector().detect(RenderScene(scene).view());
  EXPECT_EQ(found.size(), scene.markers.size());
  Quality mean;
  for (const Detection& detection : found) {
    const Quality& q = detection.quality;
    EXPECT_GT(q.decision, 0);
    EXPECT_LE(q.decision, 1);
    EXPECT_GT(q.sharpness, 0);
    EXPECT_LT(q.sharpness, 1.2);
    mean.contrast += q.contrast / static_cast<double>(found.size());
    mean.decision += q.decision / static_cast<double>(found.size());
    mean.sharpness += q.sharpness / static_cast<double>(found.size());
    mean.rms_px += q.rms_px / static_cast<double>(found.size());
  }
  return mean;
}

using Change = std::function<void(Scene*, double)>;
constexpr int kSteps = 4;

std::vector<Quality> Along(const double (&values)[kSteps], double noise, const Change& change) {
  std::vector<Quality> qualities;
  for (const double value : values) {
    Scene scene = TwelveMarkers(16);
    scene.noise = noise;
    change(&scene, value);
    qualities.push_back(MeanQuality(scene));
  }
  return qualities;
}

TEST(QualityTest, FallsWithNoise) {
  const auto q = Along({1, 4, 8, 14}, 0, [](Scene* scene, double noise) { scene->noise = noise; });
  for (int i = 1; i < kSteps; ++i) {
    EXPECT_LT(q[i].decision, q[i - 1].decision);
    EXPECT_GT(q[i].rms_px, q[i - 1].rms_px);
    EXPECT_NEAR(q[i].contrast, q[0].contrast, 0.03 * q[0].contrast);
  }
}

TEST(QualityTest, FallsWithContrast) {
  const auto q = Along({190, 120, 70, 45}, 4, [](Scene* scene, double contrast) {
    for (SceneMarker& marker : scene->markers) {
      marker.black = 120 - contrast / 2;
      marker.white = 120 + contrast / 2;
    }
  });
  for (int i = 1; i < kSteps; ++i) {
    EXPECT_LT(q[i].contrast, q[i - 1].contrast);
    EXPECT_LT(q[i].decision, q[i - 1].decision);
    EXPECT_GT(q[i].rms_px, q[i - 1].rms_px);
    EXPECT_NEAR(q[i].sharpness, q[0].sharpness, 0.05);
  }
  EXPECT_NEAR(q[0].contrast, 190, 20);
}

TEST(QualityTest, FallsWithBlur) {
  const auto q =
      Along({0.5, 0.9, 1.3, 1.7}, 4, [](Scene* scene, double blur) { scene->blur = blur; });
  for (int i = 1; i < kSteps; ++i) {
    EXPECT_LT(q[i].sharpness, q[i - 1].sharpness);
    EXPECT_LT(q[i].decision, q[i - 1].decision);
    EXPECT_LT(q[i].contrast, q[i - 1].contrast);
  }
}

// With the lens, the errors are those without it.
TEST(QualityTest, RmsIsThatOfTheVertices) {
  Scene scene = TwelveMarkers(16);
  for (const bool has_lens : {false, true}) {
    if (has_lens) {
      scene.camera.model = DistortionModel::kBrown;
      scene.camera.distortion[0] = -0.2;
    }
    Options options;
    options.camera = scene.camera;
    options.tag_size = 0.05;
    for (const Detection& d : Detector(options).detect(RenderScene(scene).view())) {
      ASSERT_TRUE(d.pose);
      // A pose has fewer parameters than a homography, and p1 and p2 move together.
      EXPECT_LT(d.quality.rms_px, 1.2 * d.pose->rms_px);
      EXPECT_GT(d.quality.rms_px, 0.4 * d.pose->rms_px);
    }
  }
}

// Where no node is solid, a hole is compared with the others.
TEST(QualityTest, MarkersOfHolesAlone) {
  for (const double level : {205, 165, 125, 85, 45}) {
    Scene scene;
    scene.camera = test::PinholeCamera(300, 300, 900);
    scene.noise = 0;
    SceneMarker marker;
    marker.design.id = marker.design.family.size() - 1;
    marker.t = {0, 0, 0.25};
    scene.markers.push_back(marker);
    scene.occluders.push_back({{{5.4, 5.4}, {6.6, 5.4}, {6.6, 6.6}, {5.4, 6.6}}, level, 0});
    const std::vector<Detection> found = Detector().detect(RenderScene(scene).view());
    ASSERT_EQ(found.size(), 1u) << level;
    const bool is_hole = level > 120;  // black is 25, white 215
    EXPECT_EQ(found[0].id, marker.design.id - (is_hole ? 0 : 1)) << level;
    if (!is_hole) continue;
    const double open = found[0].quality.sharpness, hole = (level - 25) / 190;
    EXPECT_NEAR(open, 1, 0.05) << level;
    EXPECT_NEAR(found[0].quality.decision, (hole / open - 0.15) / 0.85, 0.01) << level;
  }
}

// One hole filled with grey is as uncertain as it is grey.
TEST(QualityTest, DecisionIsTheLeastCertainBit) {
  double before = 1;
  for (const double level : {190, 160, 140}) {
    Scene scene;
    scene.camera = test::PinholeCamera(300, 300, 900);
    scene.noise = 0;
    SceneMarker marker;
    marker.design.id = 1;  // the last node has a hole
    marker.t = {0, 0, 0.25};
    scene.markers.push_back(marker);
    scene.occluders.push_back({{{5.4, 5.4}, {6.6, 5.4}, {6.6, 6.6}, {5.4, 6.6}}, level, 0});
    const std::vector<Detection> found = Detector().detect(RenderScene(scene).view());
    ASSERT_EQ(found.size(), 1u) << level;
    // Black 25, white 215: half-way is 120. The mean of the three holes falls with it.
    const double ring = (2 * 190 + level - 25) / 3 / 190;
    EXPECT_NEAR(found[0].quality.decision, 2 * std::abs((level - 25) / 190 / ring - 0.5), 0.06);
    EXPECT_LT(found[0].quality.decision, before);
    before = found[0].quality.decision;
  }
}

TEST(QualityTest, OfFarMarkersToo) {
  Scene scene = TwelveMarkers(4.5);
  const Image image = RenderScene(scene);
  Options options;
  options.far = true;
  int far = 0;
  for (const Detection& detection : Detector(options).detect(image.view())) {
    if (!detection.margin) continue;
    ++far;
    EXPECT_GT(detection.quality.contrast, 100);
    EXPECT_GT(detection.quality.decision, 0.2);
    EXPECT_LE(detection.quality.decision, 1);
    EXPECT_GT(detection.quality.sharpness, 0.05);
    EXPECT_LT(detection.quality.sharpness, 0.6);
    EXPECT_EQ(detection.quality.rms_px, 0);
  }
  EXPECT_GE(far, 6);
}

TEST(QualityTest, OfMarkersWithHiddenNodes) {
  Scene scene;
  scene.camera = test::PinholeCamera(480, 480, 600);
  SceneMarker marker;
  marker.design.id = 278;
  marker.t = {0, 0, 0.2};
  scene.markers.push_back(marker);
  scene.occluders.push_back({{{4.9, -12}, {12, -12}, {12, 12}, {4.9, 12}}, 12, 0});
  Options options;
  options.hidden_nodes = 4;
  const std::vector<Detection> found = Detector(options).detect(RenderScene(scene).view());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].unknown_bits, 0u);
  EXPECT_NEAR(found[0].quality.contrast, 190, 15);
  EXPECT_GT(found[0].quality.decision, 0.7);
  EXPECT_GT(found[0].quality.sharpness, 0.8);
  EXPECT_GT(found[0].quality.rms_px, 0);
  EXPECT_LT(found[0].quality.rms_px, 0.1);
}

TEST(QualityTest, SameOnEveryBackendAndNumberOfThreads) {
  Scene scene = TwelveMarkers(9);
  scene.noise = 6;
  const Image image = RenderScene(scene);
  Options options;
  options.backend = BackendKind::kScalar;
  options.threads = 1;
  const std::vector<Detection> expected = Detector(options).detect(image.view());
  EXPECT_GE(expected.size(), 9u);
  options.backend = BackendKind::kSimd;
  options.threads = 3;
  const std::vector<Detection> found = Detector(options).detect(image.view());
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].quality.contrast, expected[i].quality.contrast);
    EXPECT_EQ(found[i].quality.decision, expected[i].quality.decision);
    EXPECT_EQ(found[i].quality.sharpness, expected[i].quality.sharpness);
    EXPECT_EQ(found[i].quality.rms_px, expected[i].quality.rms_px);
  }
}

}  // namespace
}  // namespace topotag
