// Options::min_size.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/far.h"
#include "host/mean_side.h"
#include "host/stages.h"
#include "tests/dot_field.h"
#include "tests/scene_util.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

double Side(const Detection& detection) { return MeanSide(detection.corners.data()); }

// 5 x 4 markers with sides of 22 to 110 pixels.
Scene ManySizes(uint64_t seed) {
  test::Random random(seed);
  Scene scene;
  scene.camera = test::PinholeCamera(1000, 800, 900);
  for (int i = 0; i < 20; ++i) {
    SceneMarker marker;
    marker.design.family = Family(3 + i % 3);
    marker.design.id = random.Below(marker.design.family.size());
    const double z = 900 * marker.tag_size / random.Uniform(22, 110);
    marker.R = random.Tilted(random.Uniform(0, 50) * test::kDegree);
    marker.t = {(i % 5 - 2) * 190 * z / 900, (i / 5 - 1.5) * 190 * z / 900, z};
    scene.markers.push_back(marker);
  }
  return scene;
}

class MinSizeTest : public testing::TestWithParam<bool> {};

// What is found is what would be found otherwise, less what is smaller.
TEST_P(MinSizeTest, OnlySmallerOnesAreLeftOut) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const Image image = RenderScene(ManySizes(seed));
    Options options;
    options.far = GetParam();
    const std::vector<Detection> all = Detector(options).detect(image.view());
    EXPECT_GE(all.size(), 14u);
    for (const double size : {10.0, 30.0, 40.0, 60.0, 90.0}) {
      options.min_size = size;
      std::vector<Detection> expected;
      for (const Detection& d : all) {
        if (Side(d) >= size) expected.push_back(d);
      }
      const std::vector<Detection> found = Detector(options).detect(image.view());
      ASSERT_EQ(found.size(), expected.size()) << size << " px, seed " << seed;
      for (size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].id, expected[i].id);
        EXPECT_TRUE(found[i].center == expected[i].center);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Far, MinSizeTest, testing::Values(false, true));

TEST(MinSizeTest, IsTheMeanSideOfTheCorners) {
  const Image image = RenderScene(ManySizes(1));
  Options options;
  const std::vector<Detection> all = Detector(options).detect(image.view());
  ASSERT_FALSE(all.empty());
  const auto count = [&](double size) {
    options.min_size = size;
    return Detector(options).detect(image.view()).size();
  };
  for (const Detection& detection : all) {
    const double side = Side(detection);
    EXPECT_EQ(count(side), count(std::nextafter(side, 1e6)) + 1);
  }
}

TEST(MinSizeTest, OutOfRange) {
  Options options;
  for (const double size : {-1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    options.min_size = size;
    try {
      Detector detector(options);
      FAIL() << size;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      EXPECT_NE(std::string(error.what()).find("minimum size"), std::string::npos) << error.what();
    }
  }
}

// Markers too small to be read at once are doubts: no second look goes to what is too small.
TEST(MinSizeTest, SmallDoubtsAreLeftOut) {
  Scene scene = ManySizes(2);
  for (SceneMarker& marker : scene.markers) {
    const double z = test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size, 6);
    const double factor = z / marker.t[2];
    for (double& t : marker.t) t *= factor;
    marker.R = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  }
  const Image image = RenderScene(scene);
  Options options;
  const auto doubts = [&] {
    Detector detector(options);
    detector.detect(image.view());
    return DetectorStages(detector).Doubts().size();
  };
  EXPECT_GE(doubts(), 3u);
  options.min_size = 100;
  EXPECT_EQ(doubts(), 0u);
}

// A field of dots with pitches of 4 px: markers of 4x4 would be 17 px wide.
TEST(MinSizeTest, SmallLatticesAreLeftOut) {
  const test::DotField field;
  const auto blocks = [&](double min_size) {
    FarSearch far({Family(4)}, min_size);
    far.Start({0, 0, field.image.width(), field.image.height()}, field.grid);
    EXPECT_TRUE(far.Run(field.image.view(), nullptr).empty());
    return far.counts().blocks;
  };
  EXPECT_GT(blocks(0), 10);
  EXPECT_GT(blocks(15), 10);
  // Diagonals, and every second dot, make larger ones.
  EXPECT_EQ(blocks(60), 0);
}

}  // namespace
}  // namespace topotag
