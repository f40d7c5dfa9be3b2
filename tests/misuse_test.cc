// What a caller may get wrong with a detector is an Error that says so, never undefined behaviour:
// this is run under the sanitizers, too. Markers, scenes and objects: misuse_scene_test.

#include <gtest/gtest.h>

#include <atomic>
#include <climits>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/misuse_util.h"
#include "tests/scene_util.h"
#include "topotag/detector.h"
#include "topotag/renderer.h"
#include "topotag/tracker.h"

namespace topotag {
namespace {

constexpr int kWidth = 320, kHeight = 240;

Scene OneMarker() {
  Scene scene;
  scene.camera = test::PinholeCamera(kWidth, kHeight, 400);
  SceneMarker marker;
  marker.design.id = 278;
  marker.R = test::RotationX(0.4);
  marker.t = {0, 0, 0.2};
  scene.markers = {marker};
  return scene;
}

Options PoseOptions() {
  Options options;
  options.camera = OneMarker().camera;
  options.tag_size = 0.05;
  return options;
}

void ExpectImageRefused(const ImageView& image, const std::string& part) {
  Detector detector(PoseOptions());
  std::vector<Detection> detections(3);
  Detection detection;
  ExpectRefused(part, [&] { ValidateImage(image); });
  ExpectRefused(part, [&] { detector.detect(image); });
  ExpectRefused(part, [&] { detector.detect(image, &detections); });
  EXPECT_TRUE(detections.empty());
  ExpectRefused(part, [&] { detector.submit(image); });
  EXPECT_FALSE(detector.collect(&detections));
  ExpectRefused(part, [&] { detector.refine(image, &detection); });
}

TEST(MisuseTest, Images) {
  const Image good(kWidth, kHeight);
  const uint8_t* const data = good.view().data;
  ExpectImageRefused({}, "null");
  ExpectImageRefused({nullptr, kWidth, kHeight, kWidth}, "null");
  for (const int side : {0, -1, INT_MIN, INT_MAX, kMaxImageSide + 1}) {
    ExpectImageRefused({data, side, kHeight, INT_MAX}, "image size");
    ExpectImageRefused({data, kWidth, side, kWidth}, "image size");
  }
  for (const ptrdiff_t stride : {ptrdiff_t{0}, ptrdiff_t{kWidth - 1}, ptrdiff_t{-kWidth},
                                 PTRDIFF_MIN, PTRDIFF_MAX, PTRDIFF_MAX / kHeight + 1}) {
    ExpectImageRefused({data, kWidth, kHeight, stride}, "stride");
  }
}

TEST(MisuseTest, ImagesOfOtherSizesThanTheCameras) {
  const Image other(kWidth, kHeight + 1);
  Detector detector(PoseOptions());
  ExpectRefused("320x241", [&] { detector.detect(other.view()); });
  Options options;
  options.roi = Rect{kWidth - 10, 0, 11, 5};
  Detector part(options);
  ExpectRefused("region of interest", [&] { part.detect(Image(kWidth, kHeight).view()); });
}

void ExpectOptionsRefused(const std::string& part, const std::function<void(Options*)>& change) {
  Options options = PoseOptions();
  change(&options);
  ExpectRefused(part, [&] { Detector detector(options); });
}

TEST(MisuseTest, Cameras) {
  for (const double value : {0.0, -1.0, kNan, kInf, -kInf, 1e-300, 1e10, 1e300}) {
    ExpectOptionsRefused("fx", [&](Options* o) { o->camera->fx = value; });
    ExpectOptionsRefused("fy", [&](Options* o) { o->camera->fy = value; });
  }
  for (const double value : {kNan, kInf, -kInf, 8e13, -1e10, 1e300}) {
    ExpectOptionsRefused("cx", [&](Options* o) { o->camera->cx = value; });
    ExpectOptionsRefused("cy", [&](Options* o) { o->camera->cy = value; });
  }
  for (const double value : kNotFinite) {
    for (size_t i = 0; i < 14; ++i) {
      ExpectOptionsRefused("distortion[" + std::to_string(i) + "]",
                           [&](Options* o) { o->camera->distortion[i] = value; });
    }
  }
  ExpectOptionsRefused("width", [](Options* o) { o->camera->width = -1; });
  ExpectOptionsRefused("height", [](Options* o) { o->camera->height = INT_MIN; });
  ExpectOptionsRefused("only one", [](Options* o) { o->camera->width = 0; });
  for (const int model : {-1, 3, INT_MAX}) {
    ExpectOptionsRefused(
        "model", [&](Options* o) { o->camera->model = static_cast<DistortionModel>(model); });
  }
}

TEST(MisuseTest, TagSizes) {
  for (const double value : {-1.0, kNan, kInf, -kInf, 1e300, 9e-10, 1e-320}) {
    ExpectOptionsRefused("tag size", [&](Options* o) { o->tag_size = value; });
    ExpectOptionsRefused("tag size", [&](Options* o) { o->family_tag_size[4] = value; });
    ExpectOptionsRefused("4x4 ID 7", [&](Options* o) { o->id_tag_size[{4, 7}] = value; });
  }
  for (const int n : {-1, 0, 2, 9, INT_MAX}) {
    ExpectOptionsRefused("tag size", [&](Options* o) { o->family_tag_size[n] = 0.1; });
    ExpectOptionsRefused("tag size", [&](Options* o) { o->id_tag_size[{n, 0}] = 0.1; });
    ExpectOptionsRefused("family", [&](Options* o) { o->ids[n] = {1}; });
  }
  ExpectOptionsRefused("3x3 ID 128", [](Options* o) { o->id_tag_size[{3, 128}] = 0.1; });
  // 0 is a size that is not known: no pose.
  Options options = PoseOptions();
  options.tag_size = 0;
  const std::vector<Detection> found = Detector(options).detect(RenderScene(OneMarker()).view());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].pose);
}

TEST(MisuseTest, OtherOptions) {
  ExpectOptionsRefused("no family", [](Options* o) { o->families.clear(); });
  ExpectOptionsRefused("twice", [](Options* o) { o->families = {Family(4), Family(4)}; });
  for (const int threads : {0, -1, INT_MIN, INT_MAX, kMaxThreads + 1}) {
    ExpectOptionsRefused("threads", [&](Options* o) { o->threads = threads; });
  }
  for (const int nodes : {-1, INT_MIN, INT_MAX, kMaxVertices + 1}) {
    ExpectOptionsRefused("hidden nodes", [&](Options* o) { o->hidden_nodes = nodes; });
  }
  ExpectOptionsRefused("no ID", [](Options* o) { o->ids[4] = {}; });
  ExpectOptionsRefused("ID 128", [](Options* o) { o->ids[3] = {1, 128}; });
  ExpectOptionsRefused("ID", [](Options* o) { o->ids[8] = {UINT64_MAX}; });
  for (const Rect& roi : {Rect{-1, 0, 5, 5}, Rect{0, INT_MIN, 5, 5}, Rect{0, 0, 0, 5},
                          Rect{0, 0, 5, INT_MIN}, Rect{}}) {
    ExpectOptionsRefused("region of interest", [&](Options* o) { o->roi = roi; });
  }
  for (const int value : {-1, 99}) {
    ExpectOptionsRefused("preset", [&](Options* o) { o->preset = static_cast<Preset>(value); });
    ExpectOptionsRefused("backend",
                         [&](Options* o) { o->backend = static_cast<BackendKind>(value); });
    ExpectOptionsRefused("pose mode", [&](Options* o) { o->pose = static_cast<PoseMode>(value); });
  }
  for (const int n : {INT_MIN, -3, 0, 2, 9, INT_MAX}) {
    ExpectRefused("family", [&] { Family family(n); });
  }
}

// A region that begins in the frame, but whose end overflows.
// Names come from files, too, and may hold anything.
TEST(MisuseTest, NamesWithControlCharacters) {
  const std::string name = "4x4\n\x1b[2J";
  ExpectRefused("'4x4  [2J'", [&] { Family::Parse(name); });
  ExpectRefused("'4x4  [2J'", [&] { ParseBackend(name); });
  ExpectRefused("'4x4  [2J'", [&] { ParseInnerShape(name); });
}

TEST(MisuseTest, RegionsThatOverflow) {
  const Image image(kWidth, kHeight);
  for (const Rect& roi : {Rect{1, 1, INT_MAX, 5}, Rect{1, 1, 5, INT_MAX}, Rect{INT_MAX, 1, 5, 5},
                          Rect{1, INT_MAX, 5, INT_MAX}}) {
    Options options;
    options.roi = roi;
    Detector detector(options);
    ExpectRefused("region of interest", [&] { detector.detect(image.view()); });
  }
}

TEST(MisuseTest, NullResults) {
  const Image image(kWidth, kHeight);
  Detector detector(PoseOptions());
  ExpectRefused("detections is null", [&] { detector.detect(image.view(), nullptr); });
  ExpectRefused("detection is null", [&] { detector.refine(image.view(), nullptr); });
  ExpectRefused("detections is null", [&] { detector.collect(nullptr); });
  detector.submit(image.view());
  ExpectRefused("detections is null", [&] { detector.collect(nullptr); });
  std::vector<Detection> detections;
  EXPECT_TRUE(detector.collect(&detections)) << "the frame is still there";
}

TEST(MisuseTest, Tracker) {
  Tracker tracker({PoseOptions()});
  const Image good = RenderScene(OneMarker());
  std::vector<Detection> detections(3);
  ExpectRefused("detections", [&] { tracker.track(good.view(), nullptr); });
  ExpectRefused("null", [&] { tracker.track({}, &detections); });
  EXPECT_TRUE(detections.empty());
  Tracker other = std::move(tracker);
  for (const std::function<void()>& call : std::vector<std::function<void()>>{
           [&] { tracker.track(good.view()); }, [&] { tracker.states(); }, [&] { tracker.reset(); },
           [&] { tracker.times(); }, [&] { tracker.options(); }}) {
    ExpectRefused("moved from", call);
  }
  const size_t found = other.track(good.view()).size();
  tracker = std::move(other);
  EXPECT_EQ(tracker.track(good.view()).size(), found);
  EXPECT_EQ(tracker.options().detection.tag_size, PoseOptions().tag_size);
}

TEST(MisuseTest, MovedFromDetector) {
  const Image image = RenderScene(OneMarker());
  Detector detector(PoseOptions());
  Detector other = std::move(detector);
  std::vector<Detection> detections;
  Detection detection;
  const std::string moved = "moved from";
  // NOLINTBEGIN(bugprone-use-after-move): that is what this is about
  ExpectRefused(moved, [&] { detector.detect(image.view()); });
  ExpectRefused(moved, [&] { detector.detect(image.view(), &detections); });
  ExpectRefused(moved, [&] { detector.submit(image.view()); });
  ExpectRefused(moved, [&] { detector.collect(&detections); });
  ExpectRefused(moved, [&] { detector.refine(image.view(), &detection); });
  ExpectRefused(moved, [&] { detector.options(); });
  ExpectRefused(moved, [&] { detector.backend(); });
  ExpectRefused(moved, [&] { detector.times(); });
  // NOLINTEND(bugprone-use-after-move)
  EXPECT_EQ(other.detect(image.view()).size(), 1u);
  detector = std::move(other);
  EXPECT_EQ(detector.detect(image.view()).size(), 1u);
}

TEST(MisuseTest, FramesOutOfOrder) {
  const Image image(kWidth, kHeight);
  Detector detector(PoseOptions());
  for (int i = 0; i < Detector::kMaxSubmitted; ++i) detector.submit(image.view());
  ExpectRefused("not been collected", [&] { detector.submit(image.view()); });
  ExpectRefused("not been collected", [&] { detector.detect(image.view()); });
}

class MisuseOfRefineTest : public testing::Test {
 protected:
  void SetUp() override {
    image_ = RenderScene(OneMarker());
    const std::vector<Detection> found = detector_.detect(image_.view());
    ASSERT_EQ(found.size(), 1u);
    good_ = found[0];
    ASSERT_TRUE(good_.pose);
  }
  void Refuse(const std::string& part, const std::function<void(Detection*)>& change) {
    Detection detection = good_;
    change(&detection);
    ExpectRefused(part, [&] { detector_.refine(image_.view(), &detection); });
  }
  // What is wrong, but not impossible, is rejected or gives some pose.
  void Try(const std::function<void(Detection*)>& change) {
    Detection detection = good_;
    change(&detection);
    ExpectDefined([&] { detector_.refine(image_.view(), &detection); });
  }

  Detector detector_{PoseOptions()};
  Image image_;
  Detection good_;
};

TEST_F(MisuseOfRefineTest, ImpossibleDetections) {
  for (const double value : kNotFinite) {
    Refuse("not finite", [&](Detection* d) { d->pose->t[2] = value; });
    Refuse("not finite", [&](Detection* d) { d->pose->R[1][0] = value; });
    Refuse("not finite", [&](Detection* d) {
      d->pose->alternative.emplace();
      d->pose->alternative->t[0] = value;
    });
    Refuse("not finite", [&](Detection* d) { d->vertices[3].x = value; });
    Refuse("not finite", [&](Detection* d) { d->vertices[0].y = value; });
    Refuse("not finite", [&](Detection* d) { d->corners[2].x = value; });
    Refuse("not finite", [&](Detection* d) { d->corners[3].y = value; });
  }
  Refuse("vertices", [](Detection* d) { d->vertices.resize(0); });
  Refuse("vertices", [](Detection* d) { d->family = Family(8); });
  Refuse("range", [](Detection* d) { d->id = UINT64_MAX; });
  Refuse("range", [](Detection* d) { d->unknown_bits = UINT64_MAX; });
  ExpectRefused("vertices", [&] { good_.vertices.resize(kMaxVertices + 1); });
  ExpectRefused("vertices", [&] { good_.vertices.resize(-1); });
  Detection none = good_;
  none.pose.reset();
  EXPECT_FALSE(detector_.refine(image_.view(), &none));
}

TEST_F(MisuseOfRefineTest, PosesOfAnotherFrame) {
  for (const double scale : {-1e300, -1.0, 0.0, 1e-300, 1e-9, 0.05, 0.3, 20.0, 1e9, 1e300}) {
    for (size_t i = 0; i < 3; ++i) {
      Try([&](Detection* d) { d->pose->t[i] = scale; });
    }
    Try([&](Detection* d) { d->pose->t = {scale * 0.3, scale * 0.4, scale}; });
    Try([&](Detection* d) {
      for (Vector3& row : d->pose->R) row = {scale, scale, scale};
    });
    Try([&](Detection* d) {
      d->pose->ambiguity = 1;
      d->pose->alternative.emplace(*d->pose);
      d->pose->alternative->t = {scale, 0, scale};
    });
    Try([&](Detection* d) {
      for (Point2& vertex : d->vertices) vertex = {scale, -scale};
    });
  }
  for (const double value : kNotFinite) {
    Try([&](Detection* d) { d->center = {value, value}; });
    Try([&](Detection* d) { d->pose->ambiguity = value; });
    Try([&](Detection* d) { d->pose->covariance[2][2] = value; });
  }
  Try([](Detection* d) { d->id ^= 0xff; });
  Try([](Detection* d) { d->unknown_bits = d->family.size() - 1; });
  // Another image: as large, and of one colour.
  const Image empty(kWidth, kHeight);
  Detection detection = good_;
  EXPECT_FALSE(detector_.refine(empty.view(), &detection));
  EXPECT_EQ(detection.pose->t, good_.pose->t);
}

bool IsFinite(const Detection& detection) {
  double sum = detection.center.x + detection.center.y + detection.quality.rms_px;
  for (const Point2& p : detection.corners) sum += p.x + p.y;
  for (const Point2& p : detection.vertices) sum += p.x + p.y;
  if (!detection.pose) return std::isfinite(sum);
  for (const double value : detection.pose->t) sum += value;
  for (const auto& row : detection.pose->R) {
    for (const double value : row) sum += value;
  }
  for (const auto& row : detection.pose->covariance) {
    for (const double value : row) sum += value;
  }
  return std::isfinite(sum + detection.pose->rms_px);
}

// Cameras that are valid, but of no camera that there is; and lenses that nothing can be seen
// through.
TEST(MisuseTest, ExtremeCameras) {
  const Image image = RenderScene(OneMarker());
  for (const PoseMode mode : {PoseMode::kVertices, PoseMode::kPhotometric}) {
    int poses = 0;
    const auto detect = [&](const std::function<void(Camera*)>& change) {
      Options options = PoseOptions();
      options.pose = mode;
      options.far = true;
      change(&*options.camera);
      for (const Detection& detection : Detector(options).detect(image.view())) {
        EXPECT_TRUE(IsFinite(detection));
        poses += detection.pose ? 1 : 0;
      }
    };
    for (const double value : {1e-9, 1e9}) {
      detect([&](Camera* c) { c->fx = value; });
      detect([&](Camera* c) {
        c->fx = value;
        c->fy = 1e-9;
      });
      detect([&](Camera* c) { c->fx = c->fy = value; });
      detect([&](Camera* c) { c->cx = value; });
      detect([&](Camera* c) { c->cy = -value; });
    }
    EXPECT_GT(poses, 0);
    for (const double value : {1e-300, 1e-9, 1e9, 1e300}) {
      for (const DistortionModel model : {DistortionModel::kBrown, DistortionModel::kFisheye}) {
        for (size_t i = 0; i < 14; i += 3) {
          for (const double sign : {-1.0, 1.0}) {
            detect([&](Camera* c) {
              c->model = model;
              c->distortion[i] = sign * value;
            });
          }
        }
      }
    }
  }
}

TEST(MisuseTest, ExtremeTagSizes) {
  const Image image = RenderScene(OneMarker());
  for (const PoseMode mode : {PoseMode::kVertices, PoseMode::kPhotometric}) {
    for (const double size : {1e-9, 1e-6, 1e6}) {
      Options options = PoseOptions();
      options.pose = mode;
      options.tag_size = size;
      const std::vector<Detection> found = Detector(options).detect(image.view());
      ASSERT_EQ(found.size(), 1u);
      ASSERT_TRUE(found[0].pose);
      EXPECT_TRUE(IsFinite(found[0]));
      for (size_t i = 0; i < 6; ++i) EXPECT_GT(found[0].pose->covariance[i][i], 0);
    }
  }
}

#ifndef NDEBUG
// Builds with assertions notice it; one of both threads goes on as if it were alone.
TEST(MisuseTest, OneDetectorOnTwoThreads) {
  const Image image = RenderScene(OneMarker());
  Detector detector(PoseOptions());
  std::atomic<int> refused{0}, wrong{0};
  const auto use = [&] {
    for (int i = 0; i < 10000 && refused == 0; ++i) {
      try {
        std::vector<Detection> detections;
        detector.detect(image.view(), &detections);
        if (detections.size() != 1) ++wrong;
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
        EXPECT_EQ(error.what(), std::string("the detector is used by two threads at a time"));
        ++refused;
      }
    }
  };
  std::thread other(use);
  use();
  other.join();
  EXPECT_GT(refused, 0);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(detector.detect(image.view()).size(), 1u) << "it can be used again";
}
#endif

// From one thread to another, one after the other, is allowed.
TEST(MisuseTest, OneDetectorOnOneThreadAfterTheOther) {
  const Image image = RenderScene(OneMarker());
  Detector detector(PoseOptions());
  for (int i = 0; i < 3; ++i) {
    std::thread([&] { EXPECT_EQ(detector.detect(image.view()).size(), 1u); }).join();
  }
}

}  // namespace
}  // namespace topotag
