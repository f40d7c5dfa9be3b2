#include "host/pre_blur.h"

#include <algorithm>
#include <random>

#include "tests/scene_util.h"
#include "tests/simd_targets.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

// One pixel of the result by its definition.
int Definition(const ImageView& image, int x, int y) {
  constexpr int kWeights[] = {1, 4, 6, 4, 1};
  int sum = 0;
  for (int dy = -2; dy <= 2; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      sum += kWeights[dx + 2] * kWeights[dy + 2] *
             image.row(
                 std::clamp(y + dy, 0, image.height - 1))[std::clamp(x + dx, 0, image.width - 1)];
    }
  }
  return (sum + 128) / 256;
}

using PreBlurTest = SimdTest;

TEST_P(PreBlurTest, IsItsDefinition) {
  std::mt19937 random(1);
  PreBlurWorkspace workspace;
  for (int round = 0; round < 200; ++round) {
    const int width = 1 + static_cast<int>(random() % (round % 3 == 0 ? 5 : 150));
    const int height = 1 + static_cast<int>(random() % (round % 4 == 0 ? 5 : 40));
    Image image(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        image.row(y)[x] = static_cast<uint8_t>(round % 2 == 0 ? random() : (random() & 1) * 255);
      }
    }
    const ImageView result = PreBlur(image.view(), &workspace);
    ASSERT_EQ(result.width, width);
    ASSERT_EQ(result.height, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        ASSERT_EQ(result.row(y)[x], Definition(image.view(), x, y))
            << target() << ", " << width << "x" << height << ", row " << y << ", column " << x;
      }
    }
  }
}

TOPOTAG_INSTANTIATE_SIMD_TEST(PreBlurTest);

TEST(NoiseTest, MarkersAreReadThroughSevereNoise) {
  Options options;
  options.pre_blur = true;
  Detector smoothed(options);
  Detector plain;
  test::Random random(5);
  int read = 0;
  int plainly_read = 0;
  constexpr int kFrames = 24;
  for (int i = 0; i < kFrames; ++i) {
    Scene scene;
    scene.camera = test::PinholeCamera(500, 500, 700);
    SceneMarker marker;
    marker.design.family = Family(3 + i % 3);
    marker.design.id = random.Below(marker.design.family.size());
    marker.black = 0;
    marker.white = 255;
    marker.t[2] = test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size,
                                         random.Uniform(32, 60));
    marker.R = random.Tilted(random.Uniform(0, 20) * test::kDegree);
    scene.markers = {marker};
    scene.noise = 0.45 * 255;
    scene.seed = static_cast<uint64_t>(i);
    const Image image = RenderScene(scene);
    for (const Detection& d : smoothed.detect(image.view())) {
      EXPECT_EQ(d.id, marker.design.id);
      ++read;
    }
    plainly_read += !plain.detect(image.view()).empty();
  }
  EXPECT_GE(read, kFrames - 2);
  EXPECT_EQ(plainly_read, 0);
}

TEST(NoiseTest, SubmittedFramesAreSmoothedToo) {
  Options options;
  options.pre_blur = true;
  Detector detector(options);
  Scene scene;
  scene.camera = test::PinholeCamera(300, 300, 500);
  scene.markers.resize(1);
  scene.markers[0].t[2] = 0.2;
  std::vector<Image> frames;
  std::vector<std::vector<Detection>> expected;
  for (const double noise : {2.0, 60.0, 20.0}) {
    scene.noise = noise;
    frames.push_back(RenderScene(scene));
    expected.push_back(detector.detect(frames.back().view()));
    ASSERT_EQ(expected.back().size(), 1u);
  }
  std::vector<Detection> found;
  for (size_t i = 0; i + 1 < frames.size(); ++i) {
    detector.submit(frames[i].view());
    detector.submit(frames[i + 1].view());
    for (const size_t k : {i, i + 1}) {
      ASSERT_TRUE(detector.collect(&found));
      ASSERT_EQ(found.size(), 1u);
      EXPECT_EQ(found[0].vertices[5], expected[k][0].vertices[5]);
    }
  }
}

}  // namespace
}  // namespace topotag
