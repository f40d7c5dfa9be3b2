#include "topotag/detector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/scene_util.h"

namespace topotag {
namespace {

using test::kDegree;
using test::operator*;

Scene OneMarker(double pitch = 24) {
  Scene scene;
  scene.camera = test::PinholeCamera(480, 360, 600);
  SceneMarker marker;
  marker.design.id = 278;
  marker.t = {0, 0, test::DistanceForPitch(scene.camera, Family(4), marker.tag_size, pitch)};
  marker.R = test::RotationZ(0.3) * test::RotationX(0.4);
  scene.markers = {marker};
  return scene;
}

// Any ID of n x n, pitch of 14 px or more, turned at random and tilted by up to 50 degrees.
Scene AnyMarker(test::Random* random, int n, double max_pitch) {
  Scene scene = OneMarker(random->Uniform(14, max_pitch));
  SceneMarker& marker = scene.markers[0];
  marker.design.family = Family(n);
  marker.design.id = random->Below(marker.design.family.size());
  marker.R = random->Tilted(random->Uniform(0, 50) * kDegree);
  return scene;
}

std::vector<Detection> Detect(const Scene& scene, const Options& options = {}) {
  return Detector(options).detect(RenderScene(scene).view());
}

TEST(DetectorTest, GeometryMatchesTheTruth) {
  const Scene scene = OneMarker();
  const std::vector<Detection> found = Detect(scene);
  ASSERT_EQ(found.size(), 1u);
  const Detection truth = GroundTruth(scene, 0);
  EXPECT_EQ(found[0].family, Family(4));
  EXPECT_EQ(found[0].id, 278u);
  EXPECT_FALSE(found[0].pose);
  EXPECT_LT(test::Distance(found[0].center, truth.center), 0.02);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_LT(test::Distance(found[0].corners[i], truth.corners[i]), 0.1);
  }
  ASSERT_EQ(found[0].vertices.size(), 16);
  for (int v = 0; v < 16; ++v) {
    EXPECT_LT(test::Distance(found[0].vertices[v], truth.vertices[v]), 0.05) << v;
  }
}

TEST(DetectorTest, SortedByFamilyIdAndPlace) {
  Scene scene = OneMarker(14);
  scene.camera = test::PinholeCamera(640, 480, 600);
  SceneMarker marker = scene.markers[0];
  scene.markers.clear();
  const double z = marker.t[2];
  const struct {
    int n;
    uint64_t id;
    double x, y;
  } placed[] = {{5, 1, -0.3, -0.2}, {4, 9, 0.3, 0.22}, {4, 9, -0.3, 0.2},
                {4, 9, 0.3, -0.2},  {4, 2, 0, 0.2},    {3, 100, 0, -0.2}};
  for (const auto& p : placed) {
    marker.design.family = Family(p.n);
    marker.design.id = p.id;
    marker.t = {p.x * z, p.y * z, z};
    scene.markers.push_back(marker);
  }
  const std::vector<Detection> found = Detect(scene);
  ASSERT_EQ(found.size(), 6u);
  const int order[] = {5, 4, 3, 2, 1, 0};
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_LT(test::Distance(found[i].center, GroundTruth(scene, order[i]).center), 0.1) << i;
  }
}

TEST(DetectorTest, MirroredMarkersAreRejected) {
  test::Random random(3);
  Detector detector;
  for (int i = 0; i < 200; ++i) {
    const Scene scene = AnyMarker(&random, 3 + i % 3, 36);
    const Image image = RenderScene(scene);
    ASSERT_EQ(detector.detect(image.view()).size(), 1u);
    Image mirrored(image.width(), image.height());
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        mirrored.row(y)[x] = image.row(y)[image.width() - 1 - x];
      }
    }
    EXPECT_TRUE(detector.detect(mirrored.view()).empty()) << "case " << i;
  }
}

// A cut that leaves every node leaves the ID.
TEST(DetectorTest, ClippedMarkersAreNotReadWrong) {
  test::Random random(5);
  Detector detector;
  for (int i = 0; i < 200; ++i) {
    const Scene scene = AnyMarker(&random, 3 + i % 3, 30);
    const Image image = RenderScene(scene);
    const Detection truth = GroundTruth(scene, 0);
    // Cut through the white area: at least 2 px of it are lost on either side.
    double lo = 1e9;
    double hi = -1e9;
    for (const Point2& corner : truth.corners) {
      lo = std::min(lo, corner.x);
      hi = std::max(hi, corner.x);
    }
    const int cut = static_cast<int>(std::lround(random.Uniform(lo + 3, hi - 3)));
    const ImageView left{image.row(0), cut, image.height(), image.stride()};
    const ImageView right{image.row(0) + cut, image.width() - cut, image.height(), image.stride()};
    for (const ImageView& view : {left, right}) {
      for (const Detection& d : detector.detect(view)) {
        EXPECT_EQ(d.family, truth.family) << "case " << i;
        EXPECT_EQ(d.id, truth.id) << "case " << i;
      }
    }
  }
}

// The border cuts the last row and column off: a complete smaller grid with p1 is left.
TEST(DetectorTest, ClippedMarkersAreNotReadAsSmallerOnes) {
  Detector detector;
  for (const int n : {4, 5, 6}) {
    Scene scene = OneMarker(24);
    SceneMarker& marker = scene.markers[0];
    marker.design.family = Family(n);
    marker.t[2] = test::DistanceForPitch(scene.camera, Family(n), marker.tag_size, 24);
    for (const double angle : {0.0, 0.05, 0.1}) {
      marker.R = test::RotationZ(angle);
      const Image image = RenderScene(scene);
      for (int step = -5; step < 35; ++step) {
        // Units from the centre to the cut: the white margin of the smaller grid ends at 2 n - 3.5.
        const double cut = (2 * n - 3.5 + 0.1 * step) * 24 / 4;
        const ImageView corner{image.row(0), static_cast<int>(scene.camera.cx + cut),
                               static_cast<int>(scene.camera.cy + cut), image.stride()};
        EXPECT_TRUE(detector.detect(corner).empty()) << n << " angle " << angle << " step " << step;
      }
    }
  }
}

TEST(DetectorTest, MarkerThatFillsTheImageExactlyIsFound) {
  Scene scene = OneMarker(24);
  scene.markers[0].design.frame = 0;
  scene.markers[0].R = test::RotationZ(0);
  const Image image = RenderScene(scene);
  const Detection truth = GroundTruth(scene, 0);
  const int x = static_cast<int>(std::ceil(truth.corners[0].x + 0.5));
  const int y = static_cast<int>(std::ceil(truth.corners[0].y + 0.5));
  const int side = static_cast<int>(std::floor(truth.corners[2].x + 0.5)) - x;
  Options options;
  options.roi = Rect{x, y, side, side};
  const std::vector<Detection> found = Detector(options).detect(image.view());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].id, 278u);
  // What goes on beyond all four sides is that marker or none.
  for (int cut = 1; cut < 40; ++cut) {
    options.roi = Rect{x + cut, y + cut, side - 2 * cut, side - 2 * cut};
    for (const Detection& d : Detector(options).detect(image.view())) {
      EXPECT_EQ(d.family, Family(4)) << cut;
      EXPECT_EQ(d.id, 278u) << cut;
    }
  }
}

TEST(DetectorTest, RegionOfInterestKeepsFullFrameCoordinates) {
  const Scene scene = OneMarker(16);
  const Image image = RenderScene(scene);
  Options options;
  options.roi = Rect{150, 90, 181, 177};
  const std::vector<Detection> found = Detector(options).detect(image.view());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT(test::Distance(found[0].center, GroundTruth(scene, 0).center), 0.03);
  options.roi = Rect{0, 0, 100, 100};
  EXPECT_TRUE(Detector(options).detect(image.view()).empty());
}

TEST(DetectorTest, BigMarkerOnAFlatNoisyWallAt4K) {
  Scene scene;
  scene.camera = test::PinholeCamera(3840, 2160, 3000);
  SceneMarker marker;
  marker.design.id = 12345;
  marker.t = {0, 0, 3000 * marker.tag_size / 600};
  for (const double black : {25.0, 86.0}) {  // also ink as bright as 40 % of the white
    marker.black = black;
    for (const double angle : {0.0, 0.5}) {
      marker.R = test::RotationZ(angle) * test::RotationX(angle);
      scene.markers = {marker};
      const std::vector<Detection> found = Detect(scene);
      ASSERT_EQ(found.size(), 1u) << "black " << black << " angle " << angle;
      EXPECT_EQ(found[0].id, 12345u);
    }
  }
}

TEST(DetectorTest, AllWhiteAllBlackAndTinyImagesAreEmpty) {
  Detector detector;
  for (const int level : {0, 128, 255}) {
    for (const auto& [w, h] : {std::pair{1, 1}, {1, 500}, {500, 1}, {63, 65}, {640, 480}}) {
      const std::vector<uint8_t> pixels(static_cast<size_t>(w * h), static_cast<uint8_t>(level));
      EXPECT_TRUE(detector.detect({pixels.data(), w, h, w}).empty());
    }
  }
}

TEST(DetectorTest, ResultsDoNotDependOnEarlierFramesOrStride) {
  const Scene scene = OneMarker();
  const Image image = RenderScene(scene);
  const std::vector<Detection> fresh = Detector().detect(image.view());
  ASSERT_EQ(fresh.size(), 1u);

  Detector used;
  Scene large = OneMarker();
  large.camera = test::PinholeCamera(1301, 907, 900);
  used.detect(RenderScene(large).view());
  const uint8_t tiny[6] = {0, 255, 0, 255, 0, 255};
  used.detect({tiny, 2, 3, 2});
  const int stride = image.width() + 37;
  std::vector<uint8_t> padded(static_cast<size_t>(stride * image.height()), 170);
  for (int y = 0; y < image.height(); ++y) {
    std::copy_n(image.row(y), image.width(), padded.begin() + static_cast<ptrdiff_t>(y) * stride);
  }
  const std::vector<Detection> again =
      used.detect({padded.data(), image.width(), image.height(), stride});
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again[0].id, fresh[0].id);
  for (int v = 0; v < 16; ++v) EXPECT_EQ(again[0].vertices[v], fresh[0].vertices[v]);
  EXPECT_EQ(again[0].corners, fresh[0].corners);
}

TEST(DetectorTest, PaperPresetFindsAPlainMarker) {
  Options options;
  options.preset = Preset::kPaper;
  const std::vector<Detection> found = Detect(OneMarker(16), options);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].id, 278u);
}

TEST(DetectorTest, OnlyTheFamiliesAskedFor) {
  Options options;
  options.families = {Family(3), Family(5)};
  EXPECT_TRUE(Detect(OneMarker(), options).empty());
}

TEST(DetectorTest, TimesAddUp) {
  Detector detector;
  detector.detect(RenderScene(OneMarker()).view());
  const StageTimes& t = detector.times();
  const double sum = t.threshold + t.binarize + t.label + t.tree + t.decode + t.vertices + t.pose;
  EXPECT_GT(t.threshold, 0);
  EXPECT_LE(sum, t.total * 1.001);
  EXPECT_GT(sum, t.total * 0.5);
}

void ExpectInvalid(const Options& options, const std::string& named) {
  try {
    Detector detector(options);
    ADD_FAILURE() << "accepted, expected an error about " << named;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
  }
}

TEST(DetectorTest, WrongOptionsAreErrors) {
  Options options;
  options.families = {};
  ExpectInvalid(options, "family");
  options.families = {Family(4), Family(3), Family(4)};
  ExpectInvalid(options, "4x4");
  options = {};
  options.threads = 0;
  ExpectInvalid(options, "threads");
  for (const double size : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    options = {};
    options.tag_size = size;
    ExpectInvalid(options, "tag size");
    options = {};
    options.family_tag_size[4] = size;
    ExpectInvalid(options, "4x4");
    options = {};
    options.id_tag_size[{4, 7}] = size;
    ExpectInvalid(options, "ID 7");
  }
  options = {};
  options.family_tag_size[9] = 0.1;
  ExpectInvalid(options, "9x9");
  options = {};
  options.id_tag_size[{3, 128}] = 0.1;
  ExpectInvalid(options, "ID 128");
  options = {};
  options.camera = Camera();
  ExpectInvalid(options, "fx");
  options = {};
  options.roi = Rect{0, 0, 0, 5};
  ExpectInvalid(options, "region of interest");
}

void ExpectInvalid(Detector& detector, const ImageView& image, const std::string& named) {
  try {
    detector.detect(image);
    ADD_FAILURE() << "accepted, expected an error about " << named;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
  }
}

TEST(DetectorTest, WrongImagesAreErrors) {
  const std::vector<uint8_t> pixels(100);
  Detector detector;
  ExpectInvalid(detector, {nullptr, 10, 10, 10}, "null");
  ExpectInvalid(detector, {pixels.data(), 0, 10, 10}, "size");
  ExpectInvalid(detector, {pixels.data(), 10, -1, 10}, "size");
  ExpectInvalid(detector, {pixels.data(), 10, 10, 9}, "stride");
  ExpectInvalid(detector, {pixels.data(), kMaxImageSide + 1, 1, kMaxImageSide + 1}, "size");
  Options options;
  options.camera = test::PinholeCamera(20, 10, 100);
  Detector calibrated(options);
  ExpectInvalid(calibrated, {pixels.data(), 10, 10, 10}, "20x10");
  options = {};
  options.roi = Rect{5, 5, 6, 1};
  Detector cropped(options);
  ExpectInvalid(cropped, {pixels.data(), 10, 10, 10}, "region of interest");
  EXPECT_TRUE(detector.detect({pixels.data(), 10, 10, 10}).empty());  // still usable
}

}  // namespace
}  // namespace topotag
