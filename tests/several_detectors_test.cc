// Detectors and trackers on several threads at the same time, one for each thread: all results are
// those of one alone. That they share nothing that is not guarded is for the thread sanitizer.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "tests/detection_text.h"
#include "tests/scene_util.h"
#include "tests/tracking_video.h"
#include "topotag/detector.h"
#include "topotag/error.h"
#include "topotag/renderer.h"
#include "topotag/tracker.h"

namespace topotag {
namespace {

constexpr size_t kThreads = 3;

// Calls run(thread) on all threads at once.
template <typename Run>
void OnThreads(const Run& run) {
  std::atomic<size_t> ready{0};
  std::vector<std::thread> threads;
  for (size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      ++ready;
      while (ready < kThreads) std::this_thread::yield();
      run(t);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

Scene SmallScene(uint64_t seed) {
  test::Random random(seed);
  Scene scene;
  scene.camera = test::PinholeCamera(320, 240, 300);
  scene.blur = 0.5;
  scene.noise = 2;
  scene.seed = seed;
  for (int i = 0; i < 2; ++i) {
    SceneMarker marker;
    marker.design.family = Family(3 + static_cast<int>((seed + static_cast<uint64_t>(i)) % 3));
    marker.design.id = random.Below(marker.design.family.size());
    marker.R = random.Tilted(random.Uniform(0, 40) * test::kDegree);
    // The second one only `far` finds.
    const double z = i == 0 ? 0.15 : 0.6;
    marker.t = {(i - 0.5) * z / 2, random.Uniform(-0.1, 0.1) * z, z};
    scene.markers.push_back(marker);
  }
  return scene;
}

std::vector<Options> OptionSets(BackendKind backend) {
  std::vector<Options> sets(4);
  for (Options& options : sets) {
    options.backend = backend;
    options.threads = 2;
    options.camera = SmallScene(0).camera;
    options.tag_size = 0.05;
  }
  sets[1].pose = PoseMode::kPhotometric;
  sets[2].far = true;
  sets[3].inverted = sets[3].pre_blur = true;
  sets[3].hidden_nodes = 2;
  return sets;
}

class SeveralDetectorsTest : public ::testing::TestWithParam<BackendKind> {};

TEST_P(SeveralDetectorsTest, SameAsOne) {
  std::vector<Image> images;
  for (uint64_t seed = 0; seed < 6; ++seed) images.push_back(RenderScene(SmallScene(seed)));
  std::vector<std::vector<std::string>> expected;
  size_t markers = 0;
  for (const Options& options : OptionSets(BackendKind::kScalar)) {
    Detector detector(options);
    expected.emplace_back();
    for (const Image& image : images) {
      const std::vector<Detection> detections = detector.detect(image.view());
      expected.back().push_back(DetectionText(detections).str());
      markers += detections.size();
    }
  }
  EXPECT_GT(markers, images.size() * expected.size());

  const std::vector<Options> sets = OptionSets(GetParam());
  std::atomic<bool> is_missing{false};
  OnThreads([&](size_t thread) {
    for (size_t i = 0; i < sets.size() && !is_missing; ++i) {
      const size_t which = (thread + i) % sets.size();
      try {
        Detector detector(sets[which]);
        std::vector<Detection> detections;
        for (size_t k = 0; k <= images.size(); ++k) {  // two under way
          if (k < images.size()) detector.submit(images[k].view());
          if (k == 0) continue;
          EXPECT_TRUE(detector.collect(&detections));
          EXPECT_EQ(DetectionText(detections).str(), expected[which][k - 1])
              << "options " << which << ", frame " << k - 1;
        }
      } catch (const Error& error) {
        is_missing = error.code() == ErrorCode::kUnavailable;
        EXPECT_TRUE(is_missing) << error.what();
      }
    }
  });
  if (is_missing) GTEST_SKIP() << "without " << Name(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Backends, SeveralDetectorsTest,
                         ::testing::Values(BackendKind::kScalar, BackendKind::kSimd,
                                           BackendKind::kOpenCl),
                         [](const auto& info) { return std::string(Name(info.param)); });

TEST(SeveralTrackersTest, SameAsOne) {
  test::VideoSettings settings;
  settings.width = 640;
  settings.height = 480;
  settings.frames = 40;
  settings.markers = 2;
  settings.card_steps = 2;
  settings.card_stays = 3;
  const test::TrackingVideo video(settings);
  std::vector<Image> frames;
  for (int i = 0; i < settings.frames; ++i) frames.push_back(RenderScene(video.At(i)));
  TrackerOptions options;
  options.detection.camera = video.At(0).camera;
  options.detection.tag_size = 0.05;
  options.detection.threads = 2;
  const auto track = [&](std::vector<std::string>* texts) {
    Tracker tracker(options);
    std::vector<Detection> detections;
    for (const Image& frame : frames) {
      tracker.track(frame.view(), &detections);
      texts->push_back(DetectionText(detections).str());
    }
  };
  std::vector<std::string> expected;
  track(&expected);
  EXPECT_LT(std::count(expected.begin(), expected.end(), ""), settings.frames / 2);
  std::vector<std::vector<std::string>> texts(kThreads);
  OnThreads([&](size_t thread) { track(&texts[thread]); });
  for (const std::vector<std::string>& text : texts) EXPECT_EQ(text, expected);
}

}  // namespace
}  // namespace topotag
