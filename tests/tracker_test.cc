#include "topotag/tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/scene_util.h"
#include "tests/tracking_video.h"
#include "topotag/error.h"
#include "topotag/renderer.h"

namespace topotag {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr double kFocal = 700;
constexpr double kDepth = 0.5;  // metres: a side of 70 pixels
constexpr double kSide = kFocal * 0.05 / kDepth;

Scene EmptyScene() {
  Scene scene;
  scene.camera = test::PinholeCamera(kWidth, kHeight, kFocal);
  return scene;
}

SceneMarker MarkerAt(uint64_t id, double x, double y) {
  SceneMarker marker;
  marker.design.id = id;
  marker.R = test::RotationX(0.3);
  marker.t = {(x - (kWidth - 1) / 2.0) / kFocal * kDepth,
              (y - (kHeight - 1) / 2.0) / kFocal * kDepth, kDepth};
  return marker;
}

Image Frame(const std::vector<SceneMarker>& markers) {
  Scene scene = EmptyScene();
  scene.markers = markers;
  return RenderScene(scene);
}

TrackerOptions WithPoses() {
  TrackerOptions options;
  options.detection.camera = EmptyScene().camera;
  options.detection.tag_size = 0.05;
  options.detection.threads = 1;
  return options;
}

void ExpectSame(const std::vector<Detection>& a, const std::vector<Detection>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].family, b[i].family);
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].unknown_bits, b[i].unknown_bits);
    EXPECT_EQ(a[i].center, b[i].center);
    EXPECT_EQ(a[i].corners, b[i].corners);
    for (int k = 0; k < a[i].vertices.size(); ++k) EXPECT_EQ(a[i].vertices[k], b[i].vertices[k]);
    ASSERT_EQ(a[i].pose.has_value(), b[i].pose.has_value());
    if (!a[i].pose) continue;
    EXPECT_EQ(a[i].pose->R, b[i].pose->R);
    EXPECT_EQ(a[i].pose->t, b[i].pose->t);
    EXPECT_EQ(a[i].pose->covariance, b[i].pose->covariance);
  }
}

// A video as it was rendered, and what a detector finds in each frame.
struct Video {
  std::vector<Image> frames;
  std::vector<std::vector<Detection>> detected;
};

const Video& FastVideo() {
  static const Video video = [] {
    test::VideoSettings settings;
    settings.width = kWidth;
    settings.height = kHeight;
    settings.frames = 100;
    settings.markers = 2;
    settings.card_steps = 4;
    settings.card_stays = 8;
    Video made;
    const test::TrackingVideo source(settings);
    TrackerOptions options = WithPoses();
    options.detection.camera = source.At(0).camera;
    Detector detector(options.detection);
    for (int i = 0; i < source.frames(); ++i) {
      made.frames.push_back(RenderScene(source.At(i)));
      made.detected.push_back(detector.detect(made.frames.back().view()));
    }
    return made;
  }();
  return video;
}

TrackerOptions VideoOptions() {
  TrackerOptions options = WithPoses();
  options.detection.camera = test::TrackingVideo({kWidth, kHeight, 1}).At(0).camera;
  return options;
}

// Fast motion, sharp turns, two occlusions: what detection finds, tracking finds in the same frame,
// to the last bit, and a marker keeps its number.
TEST(TrackerTest, FindsWhatADetectorFinds) {
  const Video& video = FastVideo();
  Tracker tracker(VideoOptions());
  int in_regions = 0, regained = 0;
  for (size_t i = 0; i < video.frames.size(); ++i) {
    SCOPED_TRACE("frame " + std::to_string(i));
    const std::vector<Detection> tracked = tracker.track(video.frames[i].view());
    ExpectSame(tracked, video.detected[i]);
    ASSERT_EQ(tracker.states().size(), tracked.size());
    for (size_t k = 0; k < tracked.size(); ++k) {
      EXPECT_EQ(tracker.states()[k].in_region, !tracker.searched_whole());
      EXPECT_EQ(tracker.states()[k].number, tracked[k].id == video.detected[0][0].id ? 1u : 2u);
      regained += tracker.states()[k].missed > 0;
    }
    in_regions += !tracker.searched_whole();
  }
  EXPECT_GE(in_regions, 25);
  EXPECT_GE(regained, 3);
}

class TrackerBackendTest : public testing::TestWithParam<std::pair<BackendKind, int>> {};

INSTANTIATE_TEST_SUITE_P(
    Backends, TrackerBackendTest,
    testing::Values(std::pair(BackendKind::kScalar, 1), std::pair(BackendKind::kSimd, 2),
                    std::pair(BackendKind::kSimd, 5), std::pair(BackendKind::kOpenCl, 2)),
    [](const auto& info) {
      return std::string(Name(info.param.first)) + std::to_string(info.param.second);
    });

// Of a part of the video; also what was searched is the same.
TEST_P(TrackerBackendTest, IsTheSameEverywhere) {
  TrackerOptions options = VideoOptions();
  Tracker one(options);
  options.detection.backend = GetParam().first;
  options.detection.threads = GetParam().second;
  std::optional<Tracker> made;
  try {
    made.emplace(options);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kUnavailable) throw;
    GTEST_SKIP() << error.what();
  }
  Tracker& other = *made;
  for (size_t i = 0; i < 40; ++i) {
    SCOPED_TRACE("frame " + std::to_string(i));
    const ImageView frame = FastVideo().frames[i].view();
    ExpectSame(one.track(frame), other.track(frame));
    EXPECT_EQ(one.searched_whole(), other.searched_whole());
    EXPECT_EQ(one.regions().size(), other.regions().size());
    // A device gets whole frames only.
    const bool on_host = GetParam().first == BackendKind::kOpenCl && !other.searched_whole();
    const char* const name = Name(on_host ? BackendKind::kSimd : GetParam().first);
    EXPECT_EQ(other.backend().rfind(name, 0), 0u) << other.backend();
  }
}

TEST(TrackerTest, RegionsAreSmallAndFollowTheMarker) {
  Tracker tracker(WithPoses());
  for (int i = 0; i < 10; ++i) {
    const double x = 150 + 12 * i;
    const Image frame = Frame({MarkerAt(278, x, 240)});
    const std::vector<Detection> found = tracker.track(frame.view());
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].id, 278u);
    EXPECT_EQ(tracker.states()[0].number, 1u);
    EXPECT_EQ(tracker.states()[0].age, i + 1);
    EXPECT_EQ(tracker.states()[0].in_region, i > 0);
    if (i < 2) continue;
    ASSERT_EQ(tracker.regions().size(), 1u);
    const Rect region = tracker.regions()[0];
    EXPECT_LE(region.x, x - kSide / 2);
    EXPECT_GE(region.x + region.width, x + kSide / 2);
    EXPECT_LE(region.width, 256);
    EXPECT_LE(region.height, 176);
  }
}

TEST(TrackerTest, LooksEverywhereInTheSameFrameWhereAMarkerJumps) {
  Tracker tracker(WithPoses());
  const Image here = Frame({MarkerAt(278, 150, 150)});
  const Image there = Frame({MarkerAt(278, 480, 330)});
  for (int i = 0; i < 3; ++i) tracker.track(here.view());
  ASSERT_FALSE(tracker.searched_whole());
  ASSERT_EQ(tracker.track(there.view()).size(), 1u);
  EXPECT_TRUE(tracker.searched_whole());
  EXPECT_EQ(tracker.regions().size(), 1u);
  EXPECT_EQ(tracker.states()[0].number, 1u);
  EXPECT_EQ(tracker.states()[0].age, 4);
  EXPECT_EQ(tracker.states()[0].missed, 0);
  EXPECT_FALSE(tracker.states()[0].in_region);
}

TEST(TrackerTest, LostMarkersAreLookedForThenForgotten) {
  TrackerOptions options = WithPoses();
  options.lost_frames = 5;
  options.search_interval = 1000;
  Tracker tracker(options);
  const Image two = Frame({MarkerAt(1, 150, 240), MarkerAt(2, 480, 240)});
  const Image one = Frame({MarkerAt(1, 150, 240)});
  for (int i = 0; i < 3; ++i) tracker.track(two.view());
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(tracker.track(one.view()).size(), 1u);
    EXPECT_TRUE(tracker.searched_whole());
    EXPECT_EQ(tracker.lost(), 1);
  }
  ASSERT_EQ(tracker.track(two.view()).size(), 2u);
  EXPECT_EQ(tracker.states()[1].number, 2u);
  EXPECT_EQ(tracker.states()[1].missed, 5);
  EXPECT_EQ(tracker.states()[1].age, 4);
  EXPECT_EQ(tracker.lost(), 0);

  for (int i = 0; i < 6; ++i) tracker.track(one.view());
  EXPECT_EQ(tracker.lost(), 0);
  // Forgotten: only a search of the whole frame would find it, as another one.
  EXPECT_EQ(tracker.track(two.view()).size(), 1u);
  EXPECT_FALSE(tracker.searched_whole());
}

TEST(TrackerTest, NewMarkersAreFoundOnceAnInterval) {
  TrackerOptions options = WithPoses();
  options.search_interval = 4;
  Tracker tracker(options);
  const Image one = Frame({MarkerAt(1, 150, 240)});
  const Image two = Frame({MarkerAt(1, 150, 240), MarkerAt(2, 480, 240)});
  tracker.track(one.view());
  const std::vector<size_t> expected{1, 1, 1, 2, 2, 2, 2};
  for (const size_t count : expected) EXPECT_EQ(tracker.track(two.view()).size(), count);
  EXPECT_EQ(tracker.states()[1].number, 2u);
}

TEST(TrackerTest, WithoutAMarkerEveryFrameIsSearched) {
  Tracker tracker(WithPoses());
  const Image none = Frame({});
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(tracker.track(none.view()).empty());
    EXPECT_TRUE(tracker.searched_whole());
  }
  EXPECT_EQ(tracker.track(Frame({MarkerAt(1, 150, 240)}).view()).size(), 1u);
}

TEST(TrackerTest, MarkersOfTheSameIdAreToldByTheirPlaces) {
  Tracker tracker(WithPoses());
  // They pass each other: their order among the detections changes.
  for (int i = 0; i < 20; ++i) {
    const double left = 150 + 15 * i, right = 470 - 15 * i;
    tracker.track(Frame({MarkerAt(7, left, 150), MarkerAt(7, right, 330)}).view());
    ASSERT_EQ(tracker.states().size(), 2u) << i;
    // In the order of their y.
    EXPECT_EQ(tracker.states()[0].number, 1u) << i;
    EXPECT_EQ(tracker.states()[1].number, 2u) << i;
  }
}

TEST(TrackerTest, AnotherMarkerInThePlaceIsOneOfItsOwn) {
  Tracker tracker(WithPoses());
  for (int i = 0; i < 3; ++i) tracker.track(Frame({MarkerAt(278, 300, 240)}).view());
  const std::vector<Detection> found = tracker.track(Frame({MarkerAt(279, 300, 240)}).view());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].id, 279u);
  EXPECT_EQ(tracker.states()[0].number, 2u);
  EXPECT_EQ(tracker.states()[0].age, 1);
  EXPECT_EQ(tracker.lost(), 1);
}

TEST(TrackerTest, AMarkerThatLeavesAndReturnsIsFollowed) {
  const TrackerOptions options = WithPoses();
  Tracker tracker(options);
  Detector detector(options.detection);
  for (int i = 0; i < 24; ++i) {
    SCOPED_TRACE(i);
    // Out through the right side of the picture and back.
    const double x = 520 + 20 * (12 - std::abs(i - 12));
    const Image frame = Frame({MarkerAt(278, x, 240)});
    ExpectSame(tracker.track(frame.view()), detector.detect(frame.view()));
    for (const TrackState& state : tracker.states()) EXPECT_EQ(state.number, 1u);
  }
  EXPECT_EQ(tracker.states().size(), 1u);
}

TEST(TrackerTest, RegionsStayWithinTheRegionOfInterest) {
  TrackerOptions options = WithPoses();
  options.detection.roi = Rect{37, 51, 401, 333};
  Tracker tracker(options);
  Detector detector(options.detection);
  int in_regions = 0;
  for (int i = 0; i < 17; ++i) {
    SCOPED_TRACE(i);
    const Image frame = Frame({MarkerAt(278, 120 + 15 * i, 200)});

    ExpectSame(tracker.track(frame.view()), detector.detect(frame.view()));
    for (const Rect& region : tracker.regions()) {
      EXPECT_GE(region.x, 37);
      EXPECT_GE(region.y, 51);
      EXPECT_LE(region.x + region.width, 438);
      EXPECT_LE(region.y + region.height, 384);
    }
    in_regions += !tracker.searched_whole();
  }
  EXPECT_GE(in_regions, 14);
}

TEST(TrackerTest, TakesEveryOptionOfADetector) {
  TrackerOptions photometric = WithPoses();
  photometric.detection.pose = PoseMode::kPhotometric;
  TrackerOptions far = WithPoses();
  far.detection.far = true;
  TrackerOptions inverted = WithPoses();
  inverted.detection.inverted = true;
  TrackerOptions smooth = WithPoses();
  smooth.detection.pre_blur = true;
  TrackerOptions hidden = WithPoses();
  hidden.detection.hidden_nodes = 3;
  hidden.detection.ids = {{4, {278, 279}}};
  TrackerOptions paper = WithPoses();
  paper.detection.preset = Preset::kPaper;
  for (const TrackerOptions& options : {photometric, far, inverted, smooth, hidden, paper}) {
    Tracker tracker(options);
    for (int i = 0; i < 5; ++i) {
      const Image frame = Frame({MarkerAt(278, 200 + 10 * i, 240), MarkerAt(279, 450, 240)});
      ASSERT_EQ(tracker.track(frame.view()).size(), 2u);
      EXPECT_EQ(tracker.searched_whole(), i == 0);
      for (const TrackState& state : tracker.states()) EXPECT_EQ(state.age, i + 1);
    }
  }
}

// Each marker alone would do with a small region; all together take all of the frame.
TEST(TrackerTest, ManyMarkersAreSearchedAtOnce) {
  std::vector<SceneMarker> markers;
  for (uint64_t i = 0; i < 20; ++i) {
    markers.push_back(MarkerAt(i, 70 + 120.0 * static_cast<double>(i % 5),
                               60 + 115.0 * static_cast<double>(i / 5)));
  }
  const Image frame = Frame(markers);
  Tracker tracker(WithPoses());
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(tracker.track(frame.view()).size(), 20u);
    EXPECT_TRUE(tracker.searched_whole());
    EXPECT_TRUE(tracker.regions().empty());
  }
}

TEST(TrackerTest, BeginsAnewAfterAResetAndForAnotherSize) {
  TrackerOptions options = WithPoses();
  options.detection.camera.reset();
  Tracker tracker(options);
  const Image frame = Frame({MarkerAt(278, 300, 240), MarkerAt(1, 100, 240)});
  for (int i = 0; i < 3; ++i) tracker.track(frame.view());
  EXPECT_EQ(tracker.states()[0].age, 3);
  tracker.reset();
  tracker.track(frame.view());
  EXPECT_TRUE(tracker.searched_whole());
  EXPECT_EQ(tracker.states()[0].age, 1);
  EXPECT_EQ(tracker.states()[0].number, 1u);
  tracker.track(frame.view());
  ASSERT_FALSE(tracker.searched_whole());
  const ImageView smaller{frame.view().data, kWidth - 100, kHeight, frame.stride()};
  ASSERT_EQ(tracker.track(smaller).size(), 2u);
  EXPECT_TRUE(tracker.searched_whole());
  EXPECT_EQ(tracker.states()[0].age, 1);
}

TEST(TrackerTest, ErrorsLeaveTheTracksAsTheyWere) {
  Tracker tracker(WithPoses());
  const Image frame = Frame({MarkerAt(278, 300, 240)});
  std::vector<Detection> found;
  for (int i = 0; i < 2; ++i) tracker.track(frame.view(), &found);
  const ImageView other{frame.view().data, kWidth - 1, kHeight, frame.stride()};
  EXPECT_THROW(tracker.track(other, &found), Error);  // the camera's size is another
  EXPECT_TRUE(found.empty());
  EXPECT_TRUE(tracker.states().empty());
  EXPECT_THROW(tracker.track(ImageView{}, &found), Error);
  tracker.track(frame.view(), &found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(tracker.states()[0].age, 3);
  EXPECT_TRUE(tracker.states()[0].in_region);
}

TEST(TrackerTest, RejectsOptionsOutOfRange) {
  const auto message = [](const TrackerOptions& options) -> std::string {
    try {
      Tracker tracker(options);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      return error.what();
    }
    return "";
  };
  TrackerOptions options;
  options.search_interval = 0;
  EXPECT_NE(message(options).find("search interval 0"), std::string::npos) << message(options);
  options = {};
  options.lost_frames = -1;
  EXPECT_NE(message(options).find("lost frames -1"), std::string::npos) << message(options);
  options = {};
  options.detection.families.clear();
  EXPECT_NE(message(options).find("no family"), std::string::npos) << message(options);
}

}  // namespace
}  // namespace topotag
