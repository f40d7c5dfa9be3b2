// Near markers in strong perspective, and light that thresholds have to follow: found with the
// right ID, and nothing is read wrong.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/scene_util.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

using test::operator*;

SceneMarker RandomMarker(int n, test::Random* random) {
  SceneMarker marker;
  marker.design.family = Family(n);
  marker.design.id = random->Below(marker.design.family.size());
  return marker;
}

// Whether the first marker is found; nothing else may be.
bool IsFound(Detector* detector, const Scene& scene, const Image& image) {
  const std::vector<Detection> found = detector->detect(image.view());
  for (const Detection& d : found) {
    EXPECT_EQ(d.family, scene.markers[0].design.family);
    EXPECT_EQ(d.id, scene.markers[0].design.id);
  }
  return found.size() == 1;
}

TEST(NearTest, AtADistanceOfOneSideOfAnyRoll) {
  Detector detector;
  test::Random random(1);
  for (const int n : {3, 4, 5}) {
    for (int roll = 0; roll < 12; ++roll) {
      Scene scene;
      scene.camera = test::PinholeCamera(1200, 1200, 420);
      SceneMarker marker = RandomMarker(n, &random);
      marker.t = {0, 0, marker.tag_size};
      marker.R = test::RotationZ(roll * 30 * test::kDegree) *
                 (test::RotationX(32 * test::kDegree) * test::RotationZ(random.Uniform(0, 6.28)));
      scene.markers = {marker};
      EXPECT_TRUE(IsFound(&detector, scene, RenderScene(scene))) << n << " roll " << roll;
    }
  }
}

struct Light {
  const char* name;
  double black, white, background, blur, pitch;
};

class LightTest : public testing::TestWithParam<Light> {};

TEST_P(LightTest, EveryMarkerIsFound) {
  const Light& light = GetParam();
  Detector detector;
  test::Random random(2);
  for (int i = 0; i < 12; ++i) {
    Scene scene;
    scene.camera = test::PinholeCamera(480, 480, 700);
    SceneMarker marker = RandomMarker(3 + i % 3, &random);
    marker.black = light.black;
    marker.white = light.white;
    marker.t[2] =
        test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size, light.pitch);
    marker.R = random.Tilted(random.Uniform(0, 20) * test::kDegree);
    scene.markers = {marker};
    scene.background = light.background;
    scene.blur = light.blur;
    EXPECT_TRUE(IsFound(&detector, scene, RenderScene(scene))) << "case " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Lights, LightTest,
                         testing::Values(Light{"dark", 10, 30, 14, 0.7, 24},
                                         Light{"bright_ink", 96, 240, 90, 0.7, 40},
                                         Light{"defocused", 25, 215, 90, 8 / 3.0, 32},
                                         Light{"large_bright_ink", 96, 240, 90, 0.7, 64}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(ShadowTest, GradientsAndEdges) {
  Detector detector;
  test::Random random(3);
  int found[2] = {0, 0};
  constexpr int kFrames = 30;
  for (int i = 0; i < 2 * kFrames; ++i) {
    Scene scene;
    scene.camera = test::PinholeCamera(420, 420, 700);
    SceneMarker marker = RandomMarker(3 + i % 3, &random);
    const double pitch = random.Uniform(12, 22);
    marker.t[2] =
        test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size, pitch);
    marker.R = random.Tilted(random.Uniform(0, 30) * test::kDegree);
    scene.markers = {marker};
    scene.seed = static_cast<uint64_t>(i);
    Image image = RenderScene(scene);
    const double angle = random.Uniform(0, 2 * M_PI);
    const double side = marker.design.family.white_side() * pitch / 4;
    const bool is_edge = i % 2 == 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const double s = (x - 210) * std::cos(angle) + (y - 210) * std::sin(angle);
        const double light = is_edge ? 1 - 0.7 * 0.5 * std::erfc(-s / 0.5)
                                     : std::clamp(0.625 - 0.75 * s / side, 0.05, 1.0);
        image.row(y)[x] = static_cast<uint8_t>(std::lround(image.row(y)[x] * light));
      }
    }
    found[is_edge] += IsFound(&detector, scene, image);
  }
  EXPECT_EQ(found[0], kFrames);
  // An edge through the middle leaves some nodes of small markers neither black nor white.
  EXPECT_GE(found[1], kFrames / 2);
}

}  // namespace
}  // namespace topotag
