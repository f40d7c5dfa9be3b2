// Scenes as a whole: order of the markers, background, noise, errors.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>

#include "tests/renderer_test_util.h"
#include "topotag/error.h"
#include "topotag/renderer.h"

namespace topotag {
namespace {

TEST(RendererSceneTest, LaterMarkersCoverEarlierOnes) {
  Scene scene = FrontalScene(300, 300, 150, 150, 10);
  SceneMarker second = scene.markers[0];
  second.design.id = 0;  // the hole of vertex 2 is closed
  second.black = 40;
  scene.markers.push_back(second);
  EXPECT_EQ(At(RenderScene(scene), 150 + 20, 150 - 60), 40);
  std::swap(scene.markers[0], scene.markers[1]);
  EXPECT_EQ(At(RenderScene(scene), 150 + 20, 150 - 60), kWhite);
}

TEST(RendererSceneTest, SeedDeterminesTheNoise) {
  Scene scene = FrontalScene(200, 200, 100, 100, 8);
  scene.noise = 3;
  const Image first = RenderScene(scene), again = RenderScene(scene);
  EXPECT_EQ(Compare(first, [&](int x, int y) { return again.row(y)[x]; }).count, 0);
  scene.seed = 2;
  const Image other = RenderScene(scene);
  EXPECT_GT(Compare(first, [&](int x, int y) { return other.row(y)[x]; }).count, 30000);
}

TEST(RendererSceneTest, NoiseIsGaussianAndWhite) {
  Scene scene = FrontalScene(701, 600, 0, 0, 8);
  scene.markers.clear();
  for (const double sigma : {0.7, 2.0, 10.0}) {
    scene.noise = sigma;
    const Image image = RenderScene(scene);
    double sum = 0, sum2 = 0, sum4 = 0, right = 0, below = 0;
    for (int y = 0; y + 1 < 600; ++y) {
      for (int x = 0; x + 1 < 701; ++x) {
        const double v = image.row(y)[x] - kBackground;
        sum += v;
        sum2 += v * v;
        sum4 += v * v * v * v;
        right += v * (image.row(y)[x + 1] - kBackground);
        below += v * (image.row(y + 1)[x] - kBackground);
      }
    }
    const double n = 700.0 * 599, variance = sigma * sigma + 1.0 / 12;  // rounding adds 1/12
    EXPECT_NEAR(sum / n, 0, 5 * sigma / std::sqrt(n));
    EXPECT_NEAR(sum2 / n, variance, 0.012 * variance);
    EXPECT_NEAR(sum4 / n, 3 * variance * variance, 0.04 * 3 * variance * variance);
    EXPECT_NEAR(right / n, 0, 0.01 * variance);
    EXPECT_NEAR(below / n, 0, 0.01 * variance);
  }
}

TEST(RendererSceneTest, NoiseIsClampedNotWrapped) {
  Scene scene = FrontalScene(64, 64, 0, 0, 8);
  scene.markers.clear();
  scene.noise = 1000;
  const Image image = RenderScene(scene);
  int extreme = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) extreme += image.row(y)[x] == 0 || image.row(y)[x] == 255;
  }
  EXPECT_GT(extreme, 64 * 64 * 0.8);
}

Image Pattern(int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.row(y)[x] = static_cast<uint8_t>(x * 13 + y * 7);
  }
  return image;
}

TEST(RendererSceneTest, BackgroundImageCoversTheFrame) {
  Scene scene = FrontalScene(40, 30, 0, 0, 8);
  scene.markers.clear();
  const Image same = Pattern(40, 30);
  scene.background_image = same.view();
  EXPECT_EQ(Compare(RenderScene(scene), [&](int x, int y) { return same.row(y)[x]; }).count, 0);

  // Twice the size, and wider: averages of 2 x 2 pixels of the middle part.
  const Image wide = Pattern(100, 60);
  scene.background_image = wide.view();
  EXPECT_EQ(Compare(RenderScene(scene),
                    [&](int x, int y) {
                      const uint8_t* a = wide.row(2 * y) + 10 + 2 * x;
                      const uint8_t* b = wide.row(2 * y + 1) + 10 + 2 * x;
                      return (a[0] + a[1] + b[0] + b[1] + 2) / 4;
                    })
                .count,
            0);

  // Half the size: every second pair of pixels has source pixels at a quarter and three quarters.
  Image half(20, 20);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) half.row(y)[x] = static_cast<uint8_t>(8 * x + 4 * y);
  }
  scene.background_image = half.view();
  const Image upscaled = RenderScene(scene);
  for (int y = 0; y < 30; ++y) {
    for (int x = 1; x + 1 < 40; ++x) {
      const double expected = 8 * ((x + 0.5) / 2 - 0.5) + 4 * ((y + 5 + 0.5) / 2 - 0.5);
      EXPECT_NEAR(upscaled.row(y)[x], expected, 0.51) << x << ", " << y;
    }
  }
}

TEST(RendererSceneTest, BackgroundImageIsNotBlurred) {
  Scene scene = FrontalScene(200, 200, 100, 100, 5);
  const Image image = Pattern(200, 200);
  scene.background_image = image.view();
  const Image frame = RenderScene(scene);
  EXPECT_EQ(frame.row(3)[5], image.row(3)[5]);
  EXPECT_EQ(frame.row(100 - 55)[100], image.row(100 - 55)[100]);  // 7 pixels off the marker
  EXPECT_EQ(At(frame, 100, 100), kWhite);
}

TEST(RendererSceneTest, SmallestFramesAndNoMarker) {
  Scene scene = FrontalScene(1, 1, 0, 0, 30);
  EXPECT_EQ(RenderScene(scene).row(0)[0], kWhite);
  scene.camera.cx = scene.camera.cy = -1000;  // out of the frame
  EXPECT_EQ(RenderScene(scene).row(0)[0], kBackground);
  scene.camera.height = 300;
  scene.markers.clear();
  EXPECT_EQ(RenderScene(scene).row(299)[0], kBackground);
}

template <typename Change>
std::string ErrorOf(const Change& change) {
  Scene scene = FrontalScene(100, 100, 50, 50, 4);
  scene.markers.push_back(scene.markers[0]);
  change(&scene);
  try {
    RenderScene(scene);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "no error";
}

void ExpectContains(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << message << "\nlacks: " << part;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(RendererErrorTest, SceneValues) {
  const double nan = std::nan("");
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ErrorOf([](Scene*) {}), "no error");
  ExpectContains(ErrorOf([](Scene* s) { s->camera.width = s->camera.height = 0; }), "0x0");
  ExpectContains(ErrorOf([](Scene* s) { s->camera.width = kMaxImageSide + 1; }), "32767x100");
  ExpectContains(ErrorOf([](Scene* s) { s->camera.fx = 0; }), "fx");
  ExpectContains(ErrorOf([](Scene* s) { s->blur = -0.1; }), "blur -0.1");
  ExpectContains(ErrorOf([&](Scene* s) { s->blur = nan; }), "blur nan");
  ExpectContains(ErrorOf([](Scene* s) { s->blur = 101; }), "blur 101");
  ExpectContains(ErrorOf([](Scene* s) { s->noise = -1; }), "noise -1");
  ExpectContains(ErrorOf([&](Scene* s) { s->noise = infinity; }), "noise inf");
  ExpectContains(ErrorOf([](Scene* s) { s->background = 256; }), "background 256");
  const Image image(8, 8);
  ExpectContains(ErrorOf([&](Scene* s) {
                   s->background_image = {image.row(0), 8, 8, 7};
                 }),
                 "stride");
}

TEST(RendererErrorTest, MarkerValuesAreNamedByIndex) {
  const double nan = std::nan("");
  ExpectContains(ErrorOf([](Scene* s) { s->markers[1].tag_size = 0; }), "marker 1: tag size 0");
  ExpectContains(ErrorOf([&](Scene* s) { s->markers[0].tag_size = nan; }), "marker 0: tag size");
  ExpectContains(ErrorOf([](Scene* s) { s->markers[1].black = -1; }), "marker 1: black -1");
  ExpectContains(ErrorOf([](Scene* s) { s->markers[1].white = 300; }), "marker 1: white 300");
  ExpectContains(ErrorOf([](Scene* s) { s->markers[1].design.id = 1 << 14; }), "marker 1: ID");
  ExpectContains(ErrorOf([](Scene* s) { s->markers[1].design.frame = -1; }), "marker 1: frame");
  ExpectContains(ErrorOf([&](Scene* s) { s->markers[1].t[0] = nan; }), "marker 1: translation");
  ExpectContains(ErrorOf([&](Scene* s) { s->markers[1].R[2][2] = nan; }), "marker 1: R");
  ExpectContains(ErrorOf([](Scene* s) { s->markers[1].R[0][0] = 1.00001; }), "marker 1: R");
  ExpectContains(ErrorOf([](Scene* s) { s->markers[1].R[2][2] = -1; }), "reflection");
}

TEST(RendererErrorTest, MarkerMustBeInFrontOfTheCamera) {
  ExpectContains(ErrorOf([](Scene* s) { s->markers[1].t[2] = -0.3; }), "marker 1");
  ExpectContains(ErrorOf([](Scene* s) { s->markers[1].t[2] = 0; }), "in front of the camera");
  // Only its far corners are behind the camera.
  ExpectContains(ErrorOf([](Scene* s) {
                   s->markers[1].R = Rotation({1, 0, 0}, 1.5);
                   s->markers[1].t[2] = 0.02;
                 }),
                 "in front of the camera");
}

TEST(RendererErrorTest, MarkerMustBeWithinTheLensModelsRange) {
  // r - r^3 folds at r = 0.58: outlines beyond it would come back into the frame.
  const auto fold = [](Scene* s) {
    s->camera.model = DistortionModel::kBrown;
    s->camera.distortion = {-1};
    s->camera.fx = s->camera.fy = 100;
  };
  EXPECT_EQ(ErrorOf([&](Scene* s) { fold(s); }), "no error");
  const auto beyond = [&](Scene* s) {
    fold(s);
    s->markers[1].t = {0.09, 0, 0.12};
  };
  ExpectContains(ErrorOf(beyond), "marker 1: the point");
  ExpectContains(ErrorOf(beyond), "lens");
}

TEST(RendererErrorTest, GroundTruthIndex) {
  const Scene scene = FrontalScene(100, 100, 50, 50, 4);
  EXPECT_NO_THROW(GroundTruth(scene, 0));
  EXPECT_THROW(GroundTruth(scene, 1), Error);
  EXPECT_THROW(GroundTruth(scene, -1), Error);
}

}  // namespace
}  // namespace topotag
