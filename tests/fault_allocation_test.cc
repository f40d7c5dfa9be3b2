// Every allocation fails once, and with it all that follow: std::bad_alloc or an Error, nothing is
// lost (the address sanitizer sees that), and the next frame is detected as if nothing had been.

#include <gtest/gtest.h>
#include <pthread.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/failing_allocations.h"
#include "tests/object_util.h"
#include "tests/scene_util.h"
#include "topotag/detector.h"
#include "topotag/object_calibration.h"
#include "topotag/tracker.h"

namespace topotag {
namespace {

using test::FailEachAllocation;

Scene MarkerScene(int width, int height, double pitch) {
  Scene scene;
  scene.camera = test::PinholeCamera(width, height, 500);
  test::Random random(3);
  for (int i = 0; i < 3; ++i) {
    SceneMarker marker;
    marker.design.family = Family(3 + i);
    marker.design.id = random.Below(marker.design.family.size());
    const double z =
        test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size, pitch);
    marker.R = random.Tilted(30 * test::kDegree);
    marker.t = {(i - 1) * 0.33 * width * z / 500, 0, z};
    scene.markers.push_back(marker);
  }
  return scene;
}

std::string Text(const std::vector<Detection>& detections) {
  std::string text;
  for (const Detection& d : detections) {
    text += d.family.name() + " " + std::to_string(d.id) + " " + std::to_string(d.center.x);
    if (d.pose) text += " " + std::to_string(d.pose->t[2]);
    text += "\n";
  }
  return text;
}

struct Mode {
  const char* name;
  std::function<void(Options*)> change;
  double pitch = 10;
};

class FaultAllocationTest : public testing::TestWithParam<Mode> {
 protected:
  void SetUp() override {
    options_.threads = 1;
    options_.camera = scene_.camera;
    options_.camera->width = options_.camera->height = 0;
    options_.tag_size = 0.05;
    GetParam().change(&options_);
    try {
      expected_ = Text(Detector(options_).detect(frame_.view()));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kUnavailable) throw;
      GTEST_SKIP() << error.what();
    }
    expected_small_ = Text(Detector(options_).detect(small_.view()));
    EXPECT_NE(expected_, "");
    EXPECT_NE(expected_small_, expected_);
  }

  const Scene scene_ = MarkerScene(static_cast<int>(22 * GetParam().pitch),
                                   static_cast<int>(9 * GetParam().pitch), GetParam().pitch);
  const Image frame_ = RenderScene(scene_);
  const Image small_ = RenderScene(MarkerScene(120, 50, 5));
  Options options_;
  std::string expected_, expected_small_;
};

INSTANTIATE_TEST_SUITE_P(
    Modes, FaultAllocationTest,
    testing::Values(Mode{"Default", [](Options*) {}},
                    Mode{"TwoThreads", [](Options* o) { o->threads = 2; }},
                    Mode{"Scalar", [](Options* o) { o->backend = BackendKind::kScalar; }},
                    Mode{"Paper", [](Options* o) { o->preset = Preset::kPaper; }},
                    Mode{"SecondLook", [](Options*) {}, 7},
                    Mode{"Photometric", [](Options* o) { o->pose = PoseMode::kPhotometric; }},
                    Mode{"Far", [](Options* o) { o->far = true; }, 4},
                    Mode{"PreBlur", [](Options* o) { o->pre_blur = true; }, 26},
                    Mode{"Ids",
                         [](Options* o) {
                           o->ids[3] = {1, 2, 3};
                           o->hidden_nodes = 3;
                         }},
                    // The search of far markers takes the map of thresholds, whose size is that of
                    // the frame, from the device.
                    Mode{"OpenCl",
                         [](Options* o) {
                           o->backend = BackendKind::kOpenCl;
                           o->far = true;
                         }}),
    [](const auto& info) { return std::string(info.param.name); });

TEST_P(FaultAllocationTest, Construction) {
  if (options_.backend == BackendKind::kOpenCl) {
    GTEST_SKIP() << "PoCL's compiler keeps a lock where its own memory runs out";
  }
  FailEachAllocation([&] { Detector detector(options_); });
}

TEST_P(FaultAllocationTest, FirstFrame) {
  struct State {
    Detector detector;
    std::vector<Detection> detections;
    bool done = false;
  };
  FailEachAllocation(
      [&] {
        return State{Detector(options_), {}};
      },
      [&](State* state) {
        state->detector.detect(frame_.view(), &state->detections);
        state->done = true;
      },
      [&](State* state) {
        EXPECT_EQ(Text(state->detections), state->done ? expected_ : "");
        EXPECT_EQ(Text(state->detector.detect(frame_.view())), expected_);
      });
}

TEST_P(FaultAllocationTest, LargerFrame) {
  const auto make = [&] {
    Detector detector(options_);
    detector.detect(small_.view());
    return detector;
  };
  FailEachAllocation(
      make, [&](Detector* detector) { detector->detect(frame_.view()); },
      [&](Detector* detector) {
        EXPECT_NO_THROW(detector->detect(small_.view()));
        EXPECT_EQ(Text(detector->detect(frame_.view())), expected_);
      });
}

// A frame that cannot be collected is done with; the other one is right, and so are all that
// follow.
TEST_P(FaultAllocationTest, SubmittedFrames) {
  struct State {
    Detector detector;
    size_t submitted = 0, collected = 0;
  };
  const ImageView frames[] = {frame_.view(), small_.view()};
  const std::string expected[] = {expected_, expected_small_};
  FailEachAllocation([&] { return State{Detector(options_)}; },
                     [&](State* state) {
                       for (const ImageView& frame : frames) {
                         state->detector.submit(frame);
                         ++state->submitted;
                       }
                       std::vector<Detection> detections;
                       for (const std::string& text : expected) {
                         ++state->collected;
                         EXPECT_TRUE(state->detector.collect(&detections));
                         EXPECT_EQ(Text(detections), text);
                       }
                     },
                     [&](State* state) {
                       std::vector<Detection> detections;
                       while (state->collected < state->submitted) {
                         EXPECT_TRUE(state->detector.collect(&detections));
                         EXPECT_EQ(Text(detections), expected[state->collected++]);
                       }
                       EXPECT_FALSE(state->detector.collect(&detections));
                       EXPECT_EQ(Text(state->detector.detect(small_.view())), expected_small_);
                       EXPECT_EQ(Text(state->detector.detect(frame_.view())), expected_);
                     });
}

struct Tracked {
  Tracker tracker;
  std::vector<Detection> detections;
  bool done = false;
};

std::string Text(const Tracked& tracked) {
  std::string text = Text(tracked.detections);
  for (const TrackState& state : tracked.tracker.states()) {
    text += std::to_string(state.number) + " age " + std::to_string(state.age) + " missed " +
            std::to_string(state.missed) + (state.in_region ? " in region\n" : "\n");
  }
  return text + std::to_string(tracked.tracker.lost()) + " lost\n";
}

// After a failure there are no detections, and the tracks go on as without that frame: one that is
// searched wholly, one of which only regions are, and one of another size, which begins anew.
TEST_P(FaultAllocationTest, Tracks) {
  TrackerOptions options;
  options.detection = options_;
  const int width = std::max(480, static_cast<int>(30 * GetParam().pitch));
  const Image wide = RenderScene(MarkerScene(width, width, GetParam().pitch));
  const auto tracked = [&](const ImageView& frame, int count) {
    Tracked made{Tracker(options), {}};
    for (int i = 0; i < count; ++i) made.tracker.track(frame, &made.detections);
    return made;
  };
  EXPECT_FALSE(tracked(wide.view(), 3).tracker.searched_whole());
  const auto fail_after = [&](const ImageView& frame, int count, const ImageView& next) {
    const std::string expected = Text(tracked(frame, count + 1));
    FailEachAllocation(
        [&] {
          Tracked made = tracked(frame, count);
          made.detections = std::vector<Detection>();  // without capacity
          return made;
        },
        [&](Tracked* made) {
          made->tracker.track(next, &made->detections);
          made->done = true;
        },
        [&](Tracked* made) {
          if (!made->done) {
            EXPECT_TRUE(made->detections.empty());
            EXPECT_TRUE(made->tracker.states().empty());
            EXPECT_TRUE(made->tracker.regions().empty());
            made->tracker.track(frame, &made->detections);
          } else if (next.width != frame.width) {
            return;
          }
          EXPECT_EQ(Text(*made), expected);
        });
  };
  for (const int count : {0, 2}) fail_after(wide.view(), count, wide.view());
  fail_after(small_.view(), 2, wide.view());
}

TEST(FaultThreadsTest, ThatCannotBeStarted) {
  pthread_attr_t usual, huge;
  ASSERT_EQ(pthread_getattr_default_np(&usual), 0);
  ASSERT_EQ(pthread_getattr_default_np(&huge), 0);
  ASSERT_EQ(pthread_attr_setstacksize(&huge, size_t{1} << 46), 0);
  Options options;
  options.threads = 4;
  ASSERT_EQ(pthread_setattr_default_np(&huge), 0);
  try {
    Detector detector(options);
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUnavailable);
    EXPECT_NE(std::string(error.what()).find("no 4 threads"), std::string::npos) << error.what();
  }
  ASSERT_EQ(pthread_setattr_default_np(&usual), 0);
  EXPECT_NO_THROW(Detector detector(options));
}

TEST(FaultAllocationOfScenesTest, Rendering) {
  Scene scene = MarkerScene(48, 20, 3);
  scene.noise = 0;
  scene.markers[0].design.inner = InnerShape::kCircle;
  scene.markers[1].design.outer = OuterShape::kButterfly;
  FailEachAllocation([&] { RenderScene(scene); });
  FailEachAllocation([&] { GroundTruth(scene, 1); });
}

TEST(FaultAllocationOfObjectsTest, PoseAndCalibration) {
  const Object board = MakeGrid(Family(3), 0, 1, 3, 0.04, 0.06);
  Scene scene;
  scene.camera = test::PinholeCamera(640, 480, 600);
  for (const ObjectMarker& marker : board.markers) {
    scene.markers.push_back(test::Placed(marker, {test::RotationX(0.3), {0, 0, 0.4}}));
  }
  const std::vector<Detection> seen = test::ExactDetections(scene);
  FailEachAllocation([&] { ObjectPoseEstimator estimator(board, scene.camera); });
  FailEachAllocation([&] { return ObjectPoseEstimator(board, scene.camera); },
                     [&](ObjectPoseEstimator* estimator) {
                       ObjectPose pose;
                       estimator->estimate(seen, &pose);
                     },
                     [&](ObjectPoseEstimator* estimator) {
                       ObjectPose pose;
                       ASSERT_TRUE(estimator->estimate(seen, &pose));
                       EXPECT_NEAR(pose.t[2], 0.4, 1e-6);
                       EXPECT_EQ(pose.used.size(), 3u);
                     });
  FailEachAllocation([&] { CalibrateObject(board, {{scene.camera, seen}}); });
  FailEachAllocation([&] { MakeGrid(Family(3), 0, 2, 3, 0.04, 0.06); });
}

}  // namespace
}  // namespace topotag
