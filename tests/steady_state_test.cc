// In steady state a frame allocates nothing.

#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "tests/allocation_hooks.h"
#include "tests/frames.h"
#include "tests/scene_util.h"
#include "topotag/detector.h"
#include "topotag/tracker.h"

namespace {

std::atomic<bool> counting{false};
std::atomic<int> allocations{0};

}  // namespace

void OnAllocate(void*) {
  if (counting) ++allocations;
}
void OnFree(void*) {}

namespace topotag {
namespace {

Scene MarkerScene(int width, int height, int columns, int rows, double pitch, uint64_t seed) {
  test::Random random(seed);
  Scene scene;
  scene.camera = test::PinholeCamera(width, height, 900);
  scene.camera.model = DistortionModel::kBrown;
  scene.camera.distortion[0] = -0.05;
  const double step_x = static_cast<double>(width) / columns;
  const double step_y = static_cast<double>(height) / rows;
  for (int i = 0; i < columns * rows; ++i) {
    SceneMarker marker;
    marker.design.family = Family(3 + i % 3);
    marker.design.id = random.Below(marker.design.family.size());
    const double z =
        test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size, pitch);
    marker.R = random.Tilted(random.Uniform(0, 45) * test::kDegree);
    marker.t = {(i % columns + 0.5 - columns / 2.0) * step_x * z / 900,
                (i / columns + 0.5 - rows / 2.0) * step_y * z / 900, z};
    scene.markers.push_back(marker);
  }
  return scene;
}

class SteadyStateTest : public ::testing::TestWithParam<std::pair<BackendKind, int>> {
 protected:
  Options MakeOptions() const {
    Options options;
    options.backend = GetParam().first;
    options.threads = GetParam().second;
    return options;
  }

  // Allocations while the detector runs once over all frames.
  int Allocations(Detector* detector, const std::vector<ImageView>& frames) {
    allocations = 0;
    counting = true;
    for (const ImageView& frame : frames) detector->detect(frame, &detections_);
    counting = false;
    return allocations;
  }

  std::vector<Detection> detections_;
};

INSTANTIATE_TEST_SUITE_P(
    Backends, SteadyStateTest,
    ::testing::Values(std::pair(BackendKind::kScalar, 1), std::pair(BackendKind::kSimd, 1),
                      std::pair(BackendKind::kSimd, 2), std::pair(BackendKind::kSimd, 4)),
    [](const auto& info) {
      return std::string(Name(info.param.first)) + std::to_string(info.param.second);
    });

TEST(AllocationCountTest, EveryKindIsCounted) {
  struct alignas(128) Aligned {
    char bytes[128];
  };
  void* volatile seen = nullptr;  // what is stored here is not left out by a compiler
  allocations = 0;
  counting = true;
  int* const one = new int;
  seen = one;
  delete one;
  int* const three = new int[3];
  seen = three;
  delete[] three;
  Aligned* const aligned = new Aligned;
  seen = aligned;
  delete aligned;
  const std::vector<int> five(5);
  seen = const_cast<int*>(five.data());
  counting = false;
  EXPECT_EQ(allocations, 4);
  EXPECT_NE(seen, nullptr);
}

TEST_P(SteadyStateTest, TwentyMarkersWithPoses) {
  const Scene scene = MarkerScene(1280, 960, 5, 4, 10, 1);
  const Image image = RenderScene(scene);
  Options options = MakeOptions();
  options.camera = scene.camera;
  options.tag_size = 0.05;
  Detector detector(options);
  EXPECT_GT(Allocations(&detector, {image.view()}), 0);
  EXPECT_GE(detections_.size(), 15u);
  EXPECT_EQ(Allocations(&detector, std::vector<ImageView>(20, image.view())), 0);
}

TEST_P(SteadyStateTest, TwentyMarkersWithPhotometricPoses) {
  const Scene scene = MarkerScene(1280, 960, 5, 4, 14, 1);
  const Image image = RenderScene(scene);
  Options options = MakeOptions();
  options.camera = scene.camera;
  options.tag_size = 0.05;
  options.pose = PoseMode::kPhotometric;
  Detector detector(options);
  Allocations(&detector, {image.view()});
  EXPECT_GE(detections_.size(), 15u);
  for (const Detection& detection : detections_) {
    EXPECT_TRUE(detection.pose && detection.pose->photometric);
  }
  EXPECT_EQ(Allocations(&detector, std::vector<ImageView>(10, image.view())), 0);
}

// Too small to be read at once: doubtful areas are looked at again.
TEST_P(SteadyStateTest, SmallMarkersOfSecondLooks) {
  const Image image = RenderScene(MarkerScene(640, 480, 6, 5, 6.5, 2));
  Detector detector(MakeOptions());
  Allocations(&detector, {image.view()});
  EXPECT_GE(detections_.size(), 5u);
  EXPECT_EQ(Allocations(&detector, std::vector<ImageView>(20, image.view())), 0);
}

// Too small for the bit image, read by matched filters.
TEST_P(SteadyStateTest, MarkersOfMatchedFilters) {
  const Scene scene = MarkerScene(640, 480, 6, 5, 3.6, 2);
  const Image image = RenderScene(scene);
  Options options = MakeOptions();
  options.far = true;
  options.camera = scene.camera;
  options.tag_size = 0.05;
  Detector detector(options);
  Allocations(&detector, {image.view()});
  EXPECT_GE(detections_.size(), 5u);
  EXPECT_EQ(Allocations(&detector, std::vector<ImageView>(5, image.view())), 0);
}

TEST_P(SteadyStateTest, InvertedMarkers) {
  Scene scene = MarkerScene(640, 480, 4, 3, 9, 2);
  for (size_t i = 0; i < scene.markers.size(); i += 2) scene.markers[i].design.inverted = true;
  const Image image = RenderScene(scene);
  Options options = MakeOptions();
  options.far = true;
  options.inverted = true;
  options.min_size = 20;
  options.camera = scene.camera;
  options.tag_size = 0.05;
  options.pose = PoseMode::kPhotometric;
  Detector detector(options);
  Allocations(&detector, {image.view()});
  EXPECT_GE(detections_.size(), 8u);
  EXPECT_EQ(Allocations(&detector, std::vector<ImageView>(5, image.view())), 0);
}

// Markers that move, one that hides and comes back, whole searches between.
TEST_P(SteadyStateTest, Tracking) {
  Scene scene = MarkerScene(640, 480, 2, 2, 9, 2);
  std::vector<Image> frames;
  for (int i = 0; i < 4; ++i) {
    Scene moved = scene;
    for (SceneMarker& marker : moved.markers) marker.t[0] += 0.002 * i;
    if (i == 3) moved.markers.pop_back();
    frames.push_back(RenderScene(moved));
  }
  TrackerOptions options;
  options.detection = MakeOptions();
  options.detection.camera = scene.camera;
  options.detection.tag_size = 0.05;
  options.detection.pose = PoseMode::kPhotometric;
  options.search_interval = 7;
  options.lost_frames = 2;
  Tracker tracker(options);
  const auto run = [&] {
    tracker.reset();
    allocations = 0;
    counting = true;
    int in_regions = 0;
    for (const int i : {0, 1, 2, 1, 0, 1, 2, 3, 2, 1, 0, 0, 1, 3, 3, 3, 3, 1}) {
      tracker.track(frames[static_cast<size_t>(i)].view(), &detections_);
      in_regions += !tracker.searched_whole();
    }
    counting = false;
    EXPECT_GT(in_regions, 5);
    return allocations.load();
  };
  EXPECT_GT(run(), 0);
  EXPECT_EQ(detections_.size(), 3u);
  run();
  EXPECT_EQ(run(), 0);
}

TEST_P(SteadyStateTest, AnyContent) {
  for (int kind = 0; kind < kFrameKinds; ++kind) {
    const GuardedImage image =
        MakeFrame({600, 400, 0, FrameKind(kind), static_cast<uint64_t>(kind)});
    Detector detector(MakeOptions());
    Allocations(&detector, {image.view()});
    EXPECT_EQ(Allocations(&detector, std::vector<ImageView>(10, image.view())), 0)
        << Name(FrameKind(kind));
  }
}

// Only growth allocates: once every frame has been seen, none does, in whatever order they come.
TEST_P(SteadyStateTest, SizesThatShrinkAndGrow) {
  std::vector<GuardedImage> frames;
  for (const int side : {40, 700, 200}) {
    for (const FrameKind kind : {FrameKind::kBinaryNoise, FrameKind::kMarkers, FrameKind::kNoise}) {
      frames.push_back(MakeFrame({side, side / 2, 0, kind, static_cast<uint64_t>(side)}));
    }
  }
  const Image markers = RenderScene(MarkerScene(640, 480, 4, 3, 9, 3));
  std::vector<ImageView> views{markers.view()};
  for (const GuardedImage& frame : frames) views.push_back(frame.view());
  for (const Preset preset : {Preset::kDefault, Preset::kPaper}) {
    Options options = MakeOptions();
    options.preset = preset;
    Detector detector(options);
    EXPECT_GT(Allocations(&detector, views), 0);
    EXPECT_EQ(Allocations(&detector, views), 0);
    std::reverse(views.begin(), views.end());
    EXPECT_EQ(Allocations(&detector, views), 0);
  }
}

}  // namespace
}  // namespace topotag
