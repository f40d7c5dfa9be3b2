// Motion, light, occluders and ink growth against closed forms and against sums of simpler scenes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "host/motion.h"
#include "host/scene_levels.h"
#include "tests/renderer_test_util.h"
#include "topotag/error.h"
#include "topotag/renderer.h"

namespace topotag {
namespace {

constexpr int kSide = 160;

/// Noise-free, unrounded grey levels of a whole frame.
std::vector<double> Levels(const Scene& scene) {
  std::vector<double> levels;
  SceneLevels(scene).Render({0, 0, scene.camera.width, scene.camera.height}, &levels);
  return levels;
}

double LargestDifference(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

double Level(const std::vector<double>& levels, int x, int y) {
  return levels[static_cast<size_t>(y * kSide + x)];
}

Scene TiltedScene() {
  Scene scene = FrontalScene(kSide, kSide, 80, 80, 5);
  scene.markers[0].R = Rotation({1, 2, 0.5}, 0.6);
  scene.blur = 0.7;
  return scene;
}

/// 6 pixels along (1, 0.3) and a turn of 3 degrees in the time of the exposure, 10 ms.
Scene MovingScene() {
  Scene scene = TiltedScene();
  const double metres_per_pixel = scene.markers[0].t[2] / scene.camera.fx;
  scene.markers[0].velocity = {600 * metres_per_pixel, 180 * metres_per_pixel, 0.1};
  scene.markers[0].angular_velocity = {1, 2, 4};
  return scene;
}

TEST(RendererMotionTest, ExposureIsTheMeanOfManyInstants) {
  Scene scene = MovingScene();
  scene.exposure = 0.01;
  const std::vector<double> blurred = Levels(scene);
  constexpr int kInstants = 400;
  std::vector<double> mean(blurred.size());
  for (int k = 0; k < kInstants; ++k) {
    Scene still = scene;
    still.exposure = 0;
    still.markers[0] = MovedMarker(scene.markers[0], ((k + 0.5) / kInstants - 0.5) * 0.01);
    const std::vector<double> levels = Levels(still);
    for (size_t i = 0; i < mean.size(); ++i) mean[i] += levels[i] / kInstants;
  }
  EXPECT_LT(LargestDifference(blurred, mean), 2e-3);
  scene.exposure = 0;
  EXPECT_GT(LargestDifference(blurred, Levels(scene)), 30);
}

TEST(RendererMotionTest, EveryRowOfARollingShutterHasItsOwnTime) {
  for (const double exposure : {0.0, 0.004}) {
    for (const double row_time : {1e-4, -5e-5}) {
      Scene scene = MovingScene();
      scene.exposure = exposure;
      scene.row_time = row_time;
      const std::vector<double> rolling = Levels(scene);
      const double middle = GroundTruth(scene, 0).center.y;
      for (int y = 0; y < kSide; y += 13) {
        Scene row = scene;
        row.row_time = 0;
        row.markers[0] = MovedMarker(scene.markers[0], (y - middle) * row_time);
        std::vector<double> expected;
        SceneLevels(row).Render({0, y, kSide, 1}, &expected);
        const auto first = rolling.begin() + y * kSide;
        // The two cut the exposure into different instants.
        EXPECT_LT(LargestDifference({first, first + kSide}, expected), 2e-3) << y;
      }
    }
  }
}

TEST(RendererMotionTest, WithoutTimeNothingMoves) {
  EXPECT_EQ(LargestDifference(Levels(MovingScene()), Levels(TiltedScene())), 0);
}

double NormalIntegral2(double x, double sigma) {
  return x * 0.5 * std::erfc(-x / sigma * M_SQRT1_2) +
         sigma / std::sqrt(2 * M_PI) * std::exp(-0.5 * x * x / (sigma * sigma));
}

TEST(RendererLightTest, HardShadowOnTheWallEqualsClosedForm) {
  Scene scene = TiltedScene();
  scene.markers.clear();
  scene.lighting.shadow = Shadow{{70.3, 20}, 0, 0.4, 0};
  const std::vector<double> levels = Levels(scene);
  for (int x = 0; x < kSide; ++x) {
    const double d = x - 70.3;
    const double dark = NormalIntegral2(d + 0.5, 0.7) - NormalIntegral2(d - 0.5, 0.7);
    EXPECT_NEAR(Level(levels, x, 33), 90 * (1 - 0.6 * dark), 5e-4) << x;
  }
}

TEST(RendererLightTest, ShadowsOfBothSidesSumToTheWhole) {
  for (const double penumbra : {0.0, 7.0}) {
    Scene scene = TiltedScene();
    const std::vector<double> whole = Levels(scene);
    scene.lighting.shadow = Shadow{{78.2, 81.9}, 0.7, 0, penumbra};
    std::vector<double> sum = Levels(scene);
    scene.lighting.shadow->angle += M_PI;
    const std::vector<double> other = Levels(scene);
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += other[i];
    EXPECT_LT(LargestDifference(sum, whole), 1e-3) << penumbra;
  }
}

TEST(RendererLightTest, SharpShadowCutsPixelsByArea) {
  Scene scene = TiltedScene();
  scene.blur = 0;
  scene.lighting.shadow = Shadow{{78.2, 81.9}, 0.7, 0.3, 0};
  const std::vector<double> levels = Levels(scene);
  // The same 16 times finer, where the shadow is taken by the middles of the pixels.
  constexpr int kFine = 16;
  Scene fine = scene;
  fine.lighting.shadow.reset();
  Camera& camera = fine.camera;
  camera.width = camera.height = kFine * kSide;
  camera.fx = camera.fy = kFine * scene.camera.fx;
  camera.cx = camera.cy = kFine * (80 + 0.5) - 0.5;
  const std::vector<double> samples = Levels(fine);
  std::vector<double> mean(levels.size());
  for (int y = 0; y < kFine * kSide; ++y) {
    for (int x = 0; x < kFine * kSide; ++x) {
      const double u = (x + 0.5) / kFine - 0.5 - 78.2, v = (y + 0.5) / kFine - 0.5 - 81.9;
      const double light = u * std::cos(0.7) + v * std::sin(0.7) > 0 ? 0.3 : 1;
      mean[static_cast<size_t>(y / kFine * kSide + x / kFine)] +=
          light * samples[static_cast<size_t>(y * kFine * kSide + x)] / (kFine * kFine);
    }
  }
  EXPECT_LT(LargestDifference(levels, mean), 215 * 0.7 * 0.5 / kFine);
}

TEST(RendererLightTest, PenumbraIsLinear) {
  Scene scene = TiltedScene();
  scene.markers.clear();
  scene.lighting.shadow = Shadow{{80, 80}, M_PI / 2, 0.2, 40};
  const std::vector<double> levels = Levels(scene);
  for (const int y : {50, 65, 75, 80, 90, 95, 110}) {
    const double dark = std::clamp((y - 60) / 40.0, 0.0, 1.0);
    EXPECT_NEAR(Level(levels, 80, y), 90 * (1 - 0.8 * dark), 2e-3) << y;
  }
}

TEST(RendererLightTest, GainVignettingAndHighlights) {
  Scene scene = TiltedScene();
  const std::vector<double> plain = Levels(scene);
  Lighting& lighting = scene.lighting;
  lighting.gain = 1.5;
  lighting.gradient = {0.002, -0.001};
  lighting.vignetting = 0.3;
  lighting.highlights = {{{70, 60}, 10, 100}, {{20, 20}, 5, -30}};
  const std::vector<double> levels = Levels(scene);
  const double corner = 2 * 79.5 * 79.5;
  for (int y = 0; y < kSide; y += 7) {
    for (int x = 0; x < kSide; x += 7) {
      const double dx = x - 79.5, dy = y - 79.5;
      const auto spot = [&](double u, double v, double s) {
        return std::exp(-((x - u) * (x - u) + (y - v) * (y - v)) / (2 * s * s));
      };
      const double gain =
          1.5 * (1 + 0.002 * dx - 0.001 * dy) * (1 - 0.3 * (dx * dx + dy * dy) / corner);
      EXPECT_NEAR(Level(levels, x, y),
                  gain * Level(plain, x, y) + 100 * spot(70, 60, 10) - 30 * spot(20, 20, 5), 1e-9);
    }
  }
  lighting.gain = 3;
  EXPECT_EQ(At(RenderScene(scene), 70, 60), 255);
}

TEST(RendererOccluderTest, CoversInPixelsAndInUnits) {
  Scene scene = FrontalScene(kSide, kSide, 80, 80, 5);
  scene.occluders = {{{{60, 60}, {100, 60}, {100, 100}, {60, 100}}, 130, -1},
                     {{{-8.5, -8.5}, {0, -8.5}, {0, 0}, {-8.5, 0}}, 160, 0}};
  const std::vector<double> levels = Levels(scene);
  EXPECT_NEAR(Level(levels, 92, 92), 130, 1e-3);
  const std::vector<double> bare = Levels(FrontalScene(kSide, kSide, 80, 80, 5));
  // Half of this pixel is covered, and half of the light that blur brings from around it.
  EXPECT_NEAR(Level(levels, 60, 92), 0.5 * (130 + Level(bare, 60, 92)), 1e-3);
  EXPECT_NEAR(Level(levels, 70, 70), 160, 1e-3);  // the later one
  EXPECT_NEAR(Level(levels, 45, 45), 160, 1e-3);
  // In the plane of the marker, it goes where that goes.
  scene.markers[0].t[0] += 10 * scene.markers[0].t[2] / scene.camera.fx;
  const std::vector<double> moved = Levels(scene);
  EXPECT_NEAR(Level(moved, 87, 75), 160, 1e-3);
  EXPECT_NEAR(Level(levels, 87, 75), 130, 1e-3);
}

TEST(RendererGrowthTest, BlackGrowsByAsMuchOnEverySide) {
  constexpr double kPitch = 10;
  for (const InnerShape inner : {InnerShape::kSquare, InnerShape::kCircle}) {
    for (const double growth : {0.0, 0.13, -0.2}) {
      Scene scene = FrontalScene(300, 300, 150, 150, kPitch);
      scene.markers[0].design.inner = inner;
      scene.markers[0].growth = growth;
      std::vector<double> levels;
      // The cell of vertex 2 at (2, -6) has a hole.
      SceneLevels(scene).Render({150 + 1, 150 - 79, 39, 39}, &levels);
      double darkness = 0;
      for (const double level : levels) darkness += (215 - level) / 190;
      const double node = 3 + 2 * growth, hole = 1 - 2 * growth;
      const double share = inner == InnerShape::kSquare ? 1 : M_PI / 4;
      EXPECT_NEAR(darkness / (kPitch * kPitch), share * (node * node - hole * hole), 1e-4);
    }
  }
}

TEST(RendererGrowthTest, FrameGrowsToBothSides) {
  Scene scene = FrontalScene(300, 300, 150, 150, 10);
  scene.blur = 0;
  scene.markers[0].growth = 0.2;
  const Image image = RenderScene(scene);
  EXPECT_EQ(At(image, 150 + 83 - 1, 150), kWhite);
  EXPECT_EQ(At(image, 150 + 83 + 1, 150), kBlack);
  EXPECT_EQ(At(image, 150 + 97 - 1, 150), kBlack);
  EXPECT_EQ(At(image, 150 + 97 + 1, 150), kBackground);
}

template <typename Change>
std::string ErrorOf(const Change& change) {
  Scene scene = FrontalScene(100, 100, 50, 50, 4);
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
}

TEST(RendererConditionsErrorTest, FieldsAreNamed) {
  const double nan = std::nan("");
  const auto shadow = [](Shadow shadow) {
    return [shadow](Scene* s) { s->lighting.shadow = shadow; };
  };
  ExpectContains(ErrorOf([](Scene* s) { s->exposure = -1; }), "scene: exposure -1");
  ExpectContains(ErrorOf([&](Scene* s) { s->row_time = nan; }), "scene: row time nan");
  ExpectContains(ErrorOf([](Scene* s) { s->lighting.gain = -1; }), "lighting: gain -1");
  ExpectContains(ErrorOf([&](Scene* s) { s->lighting.gradient.y = nan; }), "gradient: y nan");
  ExpectContains(ErrorOf([](Scene* s) { s->lighting.vignetting = 2; }), "vignetting 2");
  ExpectContains(ErrorOf(shadow({{1, 2}, 0, 1.5, 0})), "shadow: factor 1.5");
  ExpectContains(ErrorOf(shadow({{1, 2}, 0, 0.5, -1})), "shadow: penumbra -1");
  ExpectContains(ErrorOf([](Scene* s) {
                   s->lighting.highlights = {{{1, 1}, 1, 1}, {{1, 1}, 0, 1}};
                 }),
                 "highlight 1: sigma 0");
  ExpectContains(ErrorOf([](Scene* s) { s->markers[0].growth = 0.5; }), "marker 0: growth 0.5");
  ExpectContains(ErrorOf([](Scene* s) {
                   s->markers[0].design.frame = 0.3;
                   s->markers[0].growth = -0.2;
                 }),
                 "marker 0: growth -0.2");
  ExpectContains(ErrorOf([&](Scene* s) { s->markers[0].velocity[1] = nan; }),
                 "marker 0: velocity nan");
  ExpectContains(ErrorOf([&](Scene* s) { s->markers[0].angular_velocity[1] = nan; }),
                 "marker 0: angular velocity nan");
  ExpectContains(ErrorOf([](Scene* s) {
                   s->markers[0].velocity[0] = 1e6;
                   s->exposure = 1;
                 }),
                 "marker 0: it moves by");
  ExpectContains(ErrorOf([](Scene* s) {
                   s->markers[0].velocity[2] = -10;
                   s->exposure = 1;
                 }),
                 "marker 0: the point");
}

TEST(RendererConditionsErrorTest, OccludersAreNamedByIndex) {
  const auto occluders = [](std::vector<Occluder> occluders) {
    return [occluders](Scene* s) { s->occluders = occluders; };
  };
  const Occluder good{{{0, 0}, {10, 0}, {0, 10}}, 40, -1};
  EXPECT_EQ(ErrorOf(occluders({good})), "no error");
  ExpectContains(ErrorOf(occluders({good, {good.outline, 256, -1}})), "occluder 1: level 256");
  ExpectContains(ErrorOf(occluders({{good.outline, 0, 1}})), "occluder 0: marker 1");
  ExpectContains(ErrorOf(occluders({{{{0, 0}, {1, 1}}, 0, -1}})), "occluder 0: the outline");
  ExpectContains(ErrorOf(occluders({{{{0, 0}, {9, 9}, {9, 0}, {0, 9}}, 0, -1}})), "not a simple");
}

}  // namespace
}  // namespace topotag
