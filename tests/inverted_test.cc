// Markers with white and black exchanged (Options::inverted).
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/random_image.h"
#include "tests/scene_util.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

constexpr double kTagSize = 0.05;  // metres

// 4 x 3 markers of 3x3, 4x4 and 5x5, every second one inverted, with a pitch in pixels.
Scene MixedScene(double pitch) {
  test::Random random(11);
  Scene scene;
  scene.camera = test::PinholeCamera(800, 600, 900);
  scene.noise = 2;
  for (int i = 0; i < 12; ++i) {
    SceneMarker marker;
    marker.tag_size = kTagSize;
    marker.design.family = Family(3 + i % 3);
    marker.design.id = random.Below(marker.design.family.size());
    marker.design.inverted = i % 2 == 1;
    const double z = test::DistanceForPitch(scene.camera, marker.design.family, kTagSize, pitch);
    marker.R = random.Tilted(30 * test::kDegree);
    marker.t = {(i % 4 - 1.5) * 200 * z / 900, (i / 4 - 1) * 200 * z / 900, z};
    scene.markers.push_back(marker);
  }
  return scene;
}

Image Complement(const ImageView& image) {
  Image result(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      result.row(y)[x] = static_cast<uint8_t>(255 - image.row(y)[x]);
    }
  }
  return result;
}

Options WithPoses(const Scene& scene) {
  Options options;
  options.camera = scene.camera;
  options.tag_size = kTagSize;
  options.inverted = true;
  return options;
}

void ExpectSame(const std::vector<Detection>& expected, const std::vector<Detection>& actual,
                bool exchanged) {
  ASSERT_EQ(expected.size(), actual.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    const Detection &a = expected[i], &b = actual[i];
    SCOPED_TRACE(a.family.name() + " " + std::to_string(a.id));
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.inverted, b.inverted != exchanged);
    EXPECT_EQ(a.unknown_bits, b.unknown_bits);
    EXPECT_EQ(a.margin, b.margin);
    ASSERT_EQ(a.vertices.size(), b.vertices.size());
    for (int k = 0; k < a.vertices.size(); ++k) EXPECT_TRUE(a.vertices[k] == b.vertices[k]);
    EXPECT_EQ(a.quality.contrast, b.quality.contrast);
    EXPECT_EQ(a.quality.decision, b.quality.decision);
    EXPECT_EQ(a.quality.sharpness, b.quality.sharpness);
    EXPECT_EQ(a.quality.rms_px, b.quality.rms_px);
    ASSERT_EQ(a.pose.has_value(), b.pose.has_value());
    if (!a.pose) continue;
    EXPECT_EQ(a.pose->R, b.pose->R);
    EXPECT_EQ(a.pose->t, b.pose->t);
    EXPECT_EQ(a.pose->covariance, b.pose->covariance);
  }
}

TEST(InvertedTest, BothKindsAreFoundOnceAndWhereTheyAre) {
  const Scene scene = MixedScene(18);
  const Image image = RenderScene(scene);
  const std::vector<Detection> found = Detector(WithPoses(scene)).detect(image.view());
  ASSERT_EQ(found.size(), scene.markers.size());
  for (size_t i = 0; i < scene.markers.size(); ++i) {
    const Detection truth = GroundTruth(scene, static_cast<int>(i));
    int count = 0;
    for (const Detection& detection : found) {
      if (!(detection.family == truth.family) || detection.id != truth.id) continue;
      ++count;
      EXPECT_EQ(detection.inverted, scene.markers[i].design.inverted);
      for (int k = 0; k < truth.vertices.size(); ++k) {
        EXPECT_LT(test::Distance(detection.vertices[k], truth.vertices[k]), 0.15);
      }
      ASSERT_TRUE(detection.pose);
      EXPECT_LT(test::Distance(detection.pose->t, truth.pose->t), 0.003 * truth.pose->t[2]);
    }
    EXPECT_EQ(count, 1);
  }
}

TEST(InvertedTest, OffMeansNone) {
  const Scene scene = MixedScene(18);
  const Image image = RenderScene(scene);
  const std::vector<Detection> found = Detector().detect(image.view());
  EXPECT_EQ(found.size(), scene.markers.size() / 2);
  for (const Detection& detection : found) EXPECT_FALSE(detection.inverted);
}

// Whatever is asked for, the complement of a frame gives the same, inverted: large markers, those
// of second looks, far ones.
class InvertedComplementTest : public testing::TestWithParam<double> {};

TEST_P(InvertedComplementTest, SameWithExchangedMarkers) {
  Scene scene = MixedScene(GetParam());
  for (SceneMarker& marker : scene.markers) marker.design.inverted = false;
  const Image image = RenderScene(scene);
  const Image complement = Complement(image.view());
  for (int kind = 0; kind < 4; ++kind) {
    SCOPED_TRACE(kind);
    Options options = WithPoses(scene);
    options.far = true;
    if (kind == 1) options.pose = PoseMode::kPhotometric;
    if (kind == 2) options.roi = Rect{150, 100, 430, 401};
    if (kind == 3) options.hidden_nodes = 3;
    const std::vector<Detection> inverted = Detector(options).detect(complement.view());
    EXPECT_GE(inverted.size(), kind == 2 ? 2u : 9u);
    options.inverted = false;
    ExpectSame(Detector(options).detect(image.view()), inverted, true);
    EXPECT_TRUE(Detector(options).detect(complement.view()).empty());
  }
}

INSTANTIATE_TEST_SUITE_P(Pitches, InvertedComplementTest, testing::Values(22, 8, 4.5));

// Of a marker that the region cuts, more is read than the region.
TEST(InvertedTest, RegionsDoNotShowEarlierFrames) {
  const Scene scene = MixedScene(22);
  const Image image = RenderScene(scene);
  const Image earlier = Complement(image.view());
  Random random(4);
  int found = 0;
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    Options options = WithPoses(scene);
    options.far = true;
    options.hidden_nodes = 8;
    options.threads = 1;
    const int x = random.Below(image.width() / 2), y = random.Below(image.height() / 2);
    options.roi = Rect{x, y, random.Between(image.width() / 4, image.width() - x),
                       random.Between(image.height() / 4, image.height() - y)};
    const std::vector<Detection> expected = Detector(options).detect(image.view());
    Detector detector(options);
    detector.detect(earlier.view());
    ExpectSame(expected, detector.detect(image.view()), false);
    found += static_cast<int>(expected.size());
  }
  EXPECT_GT(found, 60);
}

TEST(InvertedTest, SameOnEveryBackendAndNumberOfThreads) {
  const Scene scene = MixedScene(8);
  const Image image = RenderScene(scene);
  Options options = WithPoses(scene);
  options.backend = BackendKind::kScalar;
  options.threads = 1;
  const std::vector<Detection> expected = Detector(options).detect(image.view());
  EXPECT_GE(expected.size(), 10u);
  for (const BackendKind backend :
       {BackendKind::kScalar, BackendKind::kSimd, BackendKind::kOpenCl}) {
    for (const int threads : {1, 3}) {
      SCOPED_TRACE(std::string(Name(backend)) + " " + std::to_string(threads));
      options.backend = backend;
      options.threads = threads;
      try {
        ExpectSame(expected, Detector(options).detect(image.view()), false);
      } catch (const Error& error) {
        EXPECT_EQ(backend, BackendKind::kOpenCl) << error.what();  // a build or machine without
        EXPECT_EQ(error.code(), ErrorCode::kUnavailable);
      }
    }
  }
}

TEST(InvertedTest, SubmittedFramesAreAsDetectedOnes) {
  const Scene scene = MixedScene(18);
  const Image image = RenderScene(scene);
  const Image complement = Complement(image.view());
  for (const bool pre_blur : {false, true}) {
    Options options = WithPoses(scene);
    options.pre_blur = pre_blur;
    Detector detector(options);
    const std::vector<Detection> first = detector.detect(image.view());
    const std::vector<Detection> second = detector.detect(complement.view());
    EXPECT_EQ(first.size(), scene.markers.size());
    EXPECT_EQ(second.size(), scene.markers.size());
    detector.submit(image.view());
    detector.submit(complement.view());
    std::vector<Detection> found;
    ASSERT_TRUE(detector.collect(&found));
    ExpectSame(first, found, false);
    ASSERT_TRUE(detector.collect(&found));
    ExpectSame(second, found, false);
  }
}

// Also by a detector that does not look for inverted markers itself.
TEST(InvertedTest, RefineIsThePhotometricPose) {
  const Scene scene = MixedScene(18);
  const Image image = RenderScene(scene);
  Options options = WithPoses(scene);
  std::vector<Detection> refined = Detector(options).detect(image.view());
  options.inverted = false;
  Detector detector(options);
  for (Detection& detection : refined) {
    EXPECT_TRUE(detector.refine(image.view(), &detection));
    const Photometric& found = *detection.pose->photometric;
    EXPECT_NEAR(found.black, detection.inverted ? 215 : 25, 5);
    EXPECT_NEAR(found.white, detection.inverted ? 25 : 215, 5);
  }
  options.inverted = true;
  options.pose = PoseMode::kPhotometric;
  ExpectSame(Detector(options).detect(image.view()), refined, false);
}

// The pose says where to look, wherever the corners are: it may be predicted.
TEST(InvertedTest, RefineDoesNotDependOnEarlierFrames) {
  const Scene scene = MixedScene(18);
  const Image image = RenderScene(scene);
  const Image complement = Complement(image.view());
  const Image black(image.width(), image.height());
  const Options options = WithPoses(scene);
  std::vector<Detection> found = Detector(options).detect(image.view());
  std::vector<Detection> expected = found;
  Detector usual(options);
  for (Detection& detection : expected) {
    usual.detect(image.view());
    EXPECT_TRUE(usual.refine(image.view(), &detection));
  }
  for (Detection& detection : found) detection.corners = {};
  for (const ImageView& earlier : {ImageView(), image.view(), complement.view(), black.view()}) {
    std::vector<Detection> refined = found;
    for (Detection& detection : refined) {
      Detector detector(options);
      if (earlier.data != nullptr) detector.detect(earlier);
      EXPECT_TRUE(detector.refine(image.view(), &detection));
      detection.corners = expected[static_cast<size_t>(&detection - refined.data())].corners;
    }
    ExpectSame(expected, refined, false);
  }
}

TEST(InvertedTest, StageTimesAddUp) {
  const Scene scene = MixedScene(8);
  const Image image = RenderScene(scene);
  Detector detector(WithPoses(scene));
  detector.detect(image.view());
  const StageTimes& t = detector.times();
  const double sum = t.threshold + t.binarize + t.label + t.tree + t.decode + t.vertices + t.pose;
  EXPECT_GT(sum, 0.5 * t.total);
  EXPECT_LE(sum, 1.001 * t.total);
}

TEST(InvertedTest, GroundTruthSaysSo) {
  Scene scene = MixedScene(18);
  EXPECT_FALSE(GroundTruth(scene, 0).inverted);
  EXPECT_TRUE(GroundTruth(scene, 1).inverted);
}

// Every level is exchanged with the ink: paper, frame, white area, nodes and holes.
TEST(InvertedTest, RenderedInkIsExchanged) {
  Scene scene;
  scene.camera = test::PinholeCamera(200, 200, 600);
  scene.noise = 0;
  scene.background = 120;
  SceneMarker marker;
  marker.design.margin = 2;
  marker.t = {0, 0, 0.3};
  marker.black = 30;
  marker.white = 230;
  scene.markers.push_back(marker);
  const Image normal = RenderScene(scene);
  scene.markers[0].design.inverted = true;
  const Image inverted = RenderScene(scene);
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      // Outside the paper the background stays; its edge mixes both.
      const bool is_inside = x > 42 && x < 157 && y > 42 && y < 157;
      if (!is_inside) continue;
      ASSERT_NEAR(inverted.row(y)[x], 260 - normal.row(y)[x], 1) << x << " " << y;
    }
  }
  EXPECT_EQ(inverted.row(0)[0], 120);
}

}  // namespace
}  // namespace topotag
