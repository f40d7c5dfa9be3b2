// Markers whose holes and gaps the bit image does not resolve: range and steepness, clutter, no
// wrong ID, the same bytes everywhere, bounded work.

#include "host/far.h"

#include <gtest/gtest.h>

#include <cstring>
#include <iostream>
#include <set>
#include <tuple>
#include <vector>

#include "tests/dot_field.h"
#include "tests/scene_util.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

constexpr double kOuterSide = 0.05;  // of the frame, metres

Options FarOptions() {
  Options options;
  options.far = true;
  return options;
}

// One marker before a wall, seen by the middle of the paper's camera.
Scene WallScene(int n, double distance, double tilt, InnerShape inner, uint64_t seed) {
  test::Random random(seed * 7919 + 13);
  Scene scene;
  scene.camera = test::PinholeCamera(240, 180, 695);
  scene.background = 50 + 40 * static_cast<double>(seed % 4);
  scene.seed = seed;
  SceneMarker marker;
  marker.design.family = Family(n);
  marker.design.id = random.Below(marker.design.family.size());
  marker.design.inner = inner;
  marker.tag_size = kOuterSide * (4 * n + 1) / (4 * n + 3);
  marker.R = random.Tilted(tilt * test::kDegree);
  const double reach = 0.08 * distance;
  marker.t = {random.Uniform(-reach, reach), random.Uniform(-reach, reach), distance};
  scene.markers = {marker};
  return scene;
}

// Random rectangles and discs of all sizes, as sharp as a photograph.
Image Clutter(int width, int height, uint64_t seed) {
  test::Random random(seed);
  Image image(width, height);
  for (int y = 0; y < height; ++y) std::memset(image.row(y), 90, static_cast<size_t>(width));
  for (int i = 0; i < 400; ++i) {
    const double size = 3 * std::exp(random.Uniform(0, 3.5));
    const double cx = random.Uniform(0, width), cy = random.Uniform(0, height);
    const double angle = random.Uniform(0, M_PI), aspect = random.Uniform(0.2, 1);
    const auto grey = static_cast<uint8_t>(random.Uniform(10, 250));
    const bool round = random.Below(2) == 0;
    for (int y = std::max(0, static_cast<int>(cy - size)); y < std::min<double>(height, cy + size);
         ++y) {
      for (int x = std::max(0, static_cast<int>(cx - size)); x < std::min<double>(width, cx + size);
           ++x) {
        const double u = std::cos(angle) * (x - cx) + std::sin(angle) * (y - cy);
        const double v = (std::cos(angle) * (y - cy) - std::sin(angle) * (x - cx)) / aspect;
        const bool inside = round ? u * u + v * v < size * size / 2
                                  : std::max(std::abs(u), std::abs(v)) < 0.7 * size;
        if (inside) image.row(y)[x] = grey;
      }
    }
  }
  return image;
}

bool IsMarker(const Detection& detection, const SceneMarker& marker) {
  return detection.family == marker.design.family && detection.id == marker.design.id;
}

struct Cell {
  int n;
  double distance, tilt;
};

class FarRangeTest : public testing::TestWithParam<std::tuple<Cell, InnerShape>> {};

// Of 1,320 such scenes 18 are missed; their candidates are, never their IDs.
TEST_P(FarRangeTest, MarkersBeforeAWall) {
  const auto& [cell, inner] = GetParam();
  Detector detector(FarOptions());
  int found = 0;
  constexpr int kSeeds = 12;
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Scene scene = WallScene(cell.n, cell.distance, cell.tilt, inner, seed);
    const Image image = RenderScene(scene);
    for (const Detection& detection : detector.detect(image.view())) {
      ASSERT_TRUE(IsMarker(detection, scene.markers[0])) << "wrong ID, seed " << seed;
      ++found;
      if (!detection.margin) continue;
      EXPECT_GT(*detection.margin, 8);
      const Detection truth = GroundTruth(scene, 0);
      for (int v = 0; v < detection.family.vertex_count(); ++v) {
        EXPECT_LT(test::Distance(detection.vertices[v], truth.vertices[v]), 0.25)
            << "seed " << seed;
      }
    }
  }
  EXPECT_GE(found, kSeeds - 1);
}

INSTANTIATE_TEST_SUITE_P(Wall, FarRangeTest,
                         testing::Combine(testing::Values(Cell{3, 2.5, 0}, Cell{4, 2.3, 0},
                                                          Cell{5, 2.0, 0}, Cell{3, 2.0, 45},
                                                          Cell{4, 1.8, 45}, Cell{5, 1.5, 45},
                                                          Cell{4, 1.2, 0}, Cell{4, 1.2, 45}),
                                          testing::Values(InnerShape::kSquare, InnerShape::kCircle,
                                                          InnerShape::kHexagon)),
                         [](const auto& info) {
                           const Cell& cell = std::get<0>(info.param);
                           return Family(cell.n).name() + "_" +
                                  std::to_string(std::lround(100 * cell.distance)) + "cm_" +
                                  std::to_string(std::lround(cell.tilt)) + "degrees_" +
                                  Name(std::get<1>(info.param));
                         });

// Before clutter the frame does not stand out; nothing but the marker is found in it.
TEST(FarTest, MarkersBeforeClutter) {
  Detector detector(FarOptions());
  int found = 0;
  constexpr int kSeeds = 40;
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Image clutter = Clutter(240, 180, seed + 1);
    EXPECT_TRUE(detector.detect(clutter.view()).empty()) << "seed " << seed;
    Scene scene = WallScene(3 + static_cast<int>(seed % 2), 2.0, 0, InnerShape::kSquare, seed);
    scene.background_image = clutter.view();
    for (const Detection& detection : detector.detect(RenderScene(scene).view())) {
      EXPECT_TRUE(IsMarker(detection, scene.markers[0])) << "seed " << seed;
      ++found;
    }
  }
  std::cout << found << " of " << kSeeds << " before clutter\n";
  EXPECT_GE(found, kSeeds * 9 / 10);
}

// Beyond what can be read there is silence.
TEST(FarTest, NoWrongIdAtAnyDistance) {
  Detector detector(FarOptions());
  test::Random random(5);
  int found = 0;
  constexpr int kScenes = 400;
  for (uint64_t seed = 0; seed < kScenes; ++seed) {
    const int n = 3 + static_cast<int>(seed % 3);
    const auto inner = static_cast<InnerShape>(seed / 3 % 3);
    const double tilt = random.Uniform(0, 65), distance = random.Uniform(1, 3.5);
    const Scene scene = WallScene(n, distance, tilt, inner, seed + 1000);
    for (const Detection& detection : detector.detect(RenderScene(scene).view())) {
      EXPECT_TRUE(IsMarker(detection, scene.markers[0]))
          << "seed " << seed << ": " << n << "x" << n << ", " << scene.markers[0].t[2]
          << " m, read as " << detection.family.name() << " " << detection.id << ", margin "
          << detection.margin.value_or(0);
      ++found;
    }
  }
  std::cout << found << " of " << kScenes << " found\n";
}

// A part of a larger marker looks like a smaller one; here the larger one is not looked for.
TEST(FarTest, PartsOfLargerMarkersAreNotRead) {
  Detector detector(FarOptions());
  test::Random random(6);
  for (uint64_t seed = 0; seed < 150; ++seed) {
    const int n = 6 + static_cast<int>(seed % 3);
    const auto inner = static_cast<InnerShape>(seed / 3 % 3);
    const double tilt = random.Uniform(0, 65), distance = random.Uniform(0.6, 2);
    Scene scene = WallScene(n, distance, tilt, inner, seed + 2000);
    const Image clutter = Clutter(240, 180, seed);
    if (seed % 2 == 0) scene.background_image = clutter.view();
    for (const Detection& detection : detector.detect(RenderScene(scene).view())) {
      ADD_FAILURE() << "seed " << seed << ": " << n << "x" << n << " read as "
                    << detection.family.name() << " " << detection.id;
    }
  }
}

TEST(FarTest, IsOffUnlessAskedFor) {
  const Scene scene = WallScene(4, 2, 0, InnerShape::kSquare, 1);
  const Image image = RenderScene(scene);
  EXPECT_TRUE(Detector().detect(image.view()).empty());
  Options options = FarOptions();
  EXPECT_EQ(Detector(options).detect(image.view()).size(), 1u);
  options.preset = Preset::kPaper;
  EXPECT_TRUE(Detector(options).detect(image.view()).empty());
}

TEST(FarTest, SameBytesOnEveryBackendAndNumberOfThreads) {
  const Image clutter = Clutter(400, 300, 3);
  Scene scene = WallScene(4, 1.6, 30, InnerShape::kCircle, 2);
  scene.camera = test::PinholeCamera(400, 300, 695);
  scene.camera.model = DistortionModel::kBrown;
  scene.camera.distortion[0] = -0.1;
  scene.background_image = clutter.view();
  const Image image = RenderScene(scene);
  Options options = FarOptions();
  options.camera = scene.camera;
  options.tag_size = scene.markers[0].tag_size;
  std::vector<Detection> expected;
  for (const BackendKind backend : {BackendKind::kScalar, BackendKind::kSimd}) {
    for (const int threads : {1, 2, 3}) {
      options.backend = backend;
      options.threads = threads;
      const std::vector<Detection> found = Detector(options).detect(image.view());
      ASSERT_EQ(found.size(), 1u);
      ASSERT_TRUE(found[0].pose && found[0].margin);
      EXPECT_TRUE(IsMarker(found[0], scene.markers[0]));
      if (expected.empty()) expected = found;
      EXPECT_EQ(found[0].margin, expected[0].margin);
      for (int v = 0; v < found[0].vertices.size(); ++v) {
        EXPECT_EQ(found[0].vertices[v], expected[0].vertices[v]);
      }
      EXPECT_EQ(found[0].pose->R, expected[0].pose->R);
      EXPECT_EQ(found[0].pose->t, expected[0].pose->t);
      EXPECT_EQ(found[0].pose->covariance, expected[0].pose->covariance);
    }
  }
}

// The errors of the poses, in their own standard deviations.
TEST(FarTest, CovarianceOfThePose) {
  double squares[6] = {};
  int count = 0;
  for (uint64_t seed = 0; seed < 60; ++seed) {
    const Scene scene = WallScene(4, 1.4, 30, InnerShape::kSquare, seed);
    Options options = FarOptions();
    options.camera = scene.camera;
    options.tag_size = scene.markers[0].tag_size;
    const std::vector<Detection> found = Detector(options).detect(RenderScene(scene).view());
    if (found.size() != 1 || !found[0].margin || !found[0].pose) continue;
    const Pose& pose = *found[0].pose;
    // A flip of the planar pose is no error of this kind.
    if (test::AngleBetween(pose.R, scene.markers[0].R) > 20) continue;
    ++count;
    for (size_t i = 0; i < 3; ++i) {
      const double error = pose.t[i] - scene.markers[0].t[i];
      EXPECT_GT(pose.covariance[i][i], 0);
      squares[i] += error * error / pose.covariance[i + 3][i + 3];
    }
  }
  ASSERT_GT(count, 40);
  for (int i = 0; i < 3; ++i) {
    const double ratio = std::sqrt(squares[i] / count);
    std::cout << "axis " << i << ": errors are " << ratio << " standard deviations\n";
    EXPECT_GT(ratio, 0.5);
    EXPECT_LT(ratio, 2.0);
  }
}

// A field of dots is a lattice without end: the work on it is bounded.
TEST(FarTest, WorkIsBounded) {
  const test::DotField field;
  FarSearch far({Family(3), Family(4), Family(5)});
  far.Start({0, 0, field.image.width(), field.image.height()}, field.grid);
  EXPECT_TRUE(far.Run(field.image.view(), nullptr).empty());
  EXPECT_LE(far.counts().fits, FarSearch::kMaxFits);
}

}  // namespace
}  // namespace topotag
