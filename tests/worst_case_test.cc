// The stated bounds of the worst case: whatever a frame shows, memory and work grow no faster than
// its number of pixels, by known factors (host/pipeline.h, the noise limit; host/second_look.cc,
// the second looks).

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "fallback/label.h"
#include "host/second_look.h"
#include "host/stages.h"
#include "host/workers.h"
#include "simd/label.h"
#include "tests/live_bytes.h"
#include "tests/worst_patterns.h"
#include "topotag/detector.h"
#include "topotag/renderer.h"

namespace topotag {
namespace {

constexpr int kWidth = 1280, kHeight = 960;
// Measured: 40, of a detector with two threads that has seen all patterns.
constexpr double kMaxBytesPerPixel = 64;
// In times of a blank frame; measured: 30 and 200, on a busy machine twice that.
constexpr double kMaxOfLabelling = 200;
constexpr double kMaxOfCandidates = 800;

// A block has at most kMaxBlockChanges changes. A block that is taken as black adds one to each row
// of the block to its right, but has none itself; where a row ends in white there is one more.
uint64_t MaxChanges(int width, int height) {
  const auto words = static_cast<uint64_t>((width + 63) / 64);
  const auto bands = static_cast<uint64_t>((height + kBlockRows - 1) / kBlockRows);
  return bands * (words * kMaxBlockChanges + kBlockRows);
}

// Where the colour changes m times there are m + 1 runs.
uint64_t MaxRuns(int width, int height) {
  return MaxChanges(width, height) + static_cast<uint64_t>(height);
}

// Of bounds and of labels, for each block: rows and bands are padded.
uint64_t MaxReserved(int width, int height) {
  const auto words = static_cast<uint64_t>((width + 63) / 64);
  const auto bands = static_cast<uint64_t>((height + kBlockRows - 1) / kBlockRows);
  return bands * (words * (kMaxBlockChanges + kBlockRows) + kBlockRows * 5 + 64);
}

uint64_t Runs(const Components& components) {
  uint64_t runs = 0;
  for (int y = 0; y < components.height; ++y) runs += components.row_runs[static_cast<size_t>(y)];
  return runs;
}

void ExpectBounded(const Components& components, const std::string& name) {
  const int width = components.width, height = components.height;
  EXPECT_LE(Runs(components), MaxRuns(width, height)) << name;
  EXPECT_LE(components.label_end(), MaxRuns(width, height) + 1) << name;
  EXPECT_LE(components.bound.capacity(), MaxReserved(width, height)) << name;
  EXPECT_LE(components.label.capacity(), MaxReserved(width, height)) << name;
  EXPECT_LE(components.root.capacity(), MaxRuns(width, height) + 1) << name;
  EXPECT_LE(components.parent.capacity(), MaxRuns(width, height) + 1) << name;
  EXPECT_LE(components.white.capacity(), MaxRuns(width, height) + 1) << name;
}

// New memory for every picture: what is reserved is this one's.
TEST(WorstCaseTest, RunsAndLabelsAreBoundedForEveryPattern) {
  Workers one(1), two(2);
  for (const auto& [width, height] : {std::pair(640, 480), std::pair(333, 77), std::pair(65, 17)}) {
    for (const Pattern& pattern : AllPatterns(width, height)) {
      const BitImage bits = MakeBits(width, height, pattern.white);
      const std::string name =
          pattern.name + ", " + std::to_string(width) + "x" + std::to_string(height);
      {
        scalar::LabelWorkspace workspace;
        Components components;
        scalar::Label(bits, &workspace, &components);
        ExpectBounded(components, name + ", scalar");
      }
      for (Workers* workers : {&one, &two}) {
        simd::LabelWorkspace workspace;
        Components components;
        simd::Label(bits, workers, &workspace, &components);
        ExpectBounded(components, name + ", simd");
      }
    }
  }
}

// The bound is not idle: there are pictures close to it.
TEST(WorstCaseTest, TheBoundOfRunsIsReached) {
  uint64_t most = 0;
  for (const Pattern& pattern : PatternsAtTheNoiseLimit()) {
    scalar::LabelWorkspace workspace;
    Components components;
    scalar::Label(MakeBits(640, 480, pattern.white), &workspace, &components);
    most = std::max(most, Runs(components));
  }
  EXPECT_GT(10 * most, 9 * MaxRuns(640, 480));
}

Options MakeOptions(int threads) {
  Options options;
  options.backend = BackendKind::kSimd;
  options.threads = threads;
  return options;
}

// Peak of a detector's memory over all patterns, bytes.
int64_t PeakMemory(const std::vector<PaddedImage>& images, int threads) {
  const PeakBytes peak;
  Detector detector(MakeOptions(threads));
  std::vector<Detection> detections;
  for (const PaddedImage& image : images) detector.detect(image.view(), &detections);
  return peak.Get();
}

// The memory of a detector that has seen all of them: a factor of the pixels.
TEST(WorstCaseTest, MemoryIsBoundedByThePixels) {
  for (const auto& [width, height] : {std::pair(640, 480), std::pair(kWidth, kHeight)}) {
    std::vector<PaddedImage> images;
    for (auto make : {PeriodicPatterns, CandidatePatterns}) {
      for (const Pattern& pattern : make(width, height)) {
        images.push_back(Draw(pattern, width, height));
      }
    }
    for (const Pattern& pattern : PatternsAtTheNoiseLimit()) {
      images.push_back(Draw(pattern, width, height));
    }
    const int64_t pixels = int64_t{width} * height;
    for (const int threads : {1, 2}) {
      const double bytes = static_cast<double>(PeakMemory(images, threads)) / pixels;
      RecordProperty("bytes_per_pixel", std::to_string(bytes));
      EXPECT_LT(bytes, kMaxBytesPerPixel) << width << "x" << height << ", threads " << threads;
    }
  }
}

constexpr double kNoLimit = std::numeric_limits<double>::max();

class Clock {
 public:
  explicit Clock(int threads) : detector_(MakeOptions(threads)) {}

  /// Seconds of the fastest of some frames. Goes on for up to a thousand frames while that is
  /// longer than `limit`: others may have the machine for a while.
  double Fastest(const ImageView& image, double limit, int frames = 5) {
    double fastest = std::numeric_limits<double>::max();
    for (int i = 0; i < frames || (fastest >= limit && i < 1000); ++i) {
      const auto begin = std::chrono::steady_clock::now();
      detector_.detect(image, &detections_);
      const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
      fastest = std::min(fastest, time.count());
    }
    return fastest;
  }

 private:
  Detector detector_;
  std::vector<Detection> detections_;
};

// With wide margins: a machine may be busy. What a stage that is quadratic in the pixels of a
// component, or looks that are not limited, would take is far beyond.
TEST(WorstCaseTest, NoPatternTakesMuchLongerThanABlankFrame) {
  Clock clock(1);
  const Pattern blank{"blank", [](int, int) { return true; }};
  const double usual = clock.Fastest(Draw(blank, kWidth, kHeight).view(), kNoLimit, 50);
  std::vector<std::pair<Pattern, double>> patterns;
  for (Pattern& p : PatternsAtTheNoiseLimit()) patterns.emplace_back(std::move(p), kMaxOfLabelling);
  for (Pattern& p : PeriodicPatterns(kWidth, kHeight)) {
    patterns.emplace_back(std::move(p), kMaxOfLabelling);
  }
  for (Pattern& p : NoisePatterns(kWidth, kHeight)) {
    patterns.emplace_back(std::move(p), kMaxOfLabelling);
  }
  for (Pattern& p : CandidatePatterns(kWidth, kHeight)) {
    patterns.emplace_back(std::move(p), kMaxOfCandidates);
  }
  double worst = 0;
  std::string worst_name;
  for (const auto& [pattern, limit] : patterns) {
    const PaddedImage image = Draw(pattern, kWidth, kHeight);
    const double ratio = clock.Fastest(image.view(), limit * usual) / usual;
    EXPECT_LT(ratio, limit) << pattern.name;
    if (ratio > worst) {
      worst = ratio;
      worst_name = pattern.name;
    }
  }
  RecordProperty("worst", worst_name + ", " + std::to_string(worst) + " blank frames");
}

// Four times the pixels take about four times as long, whatever they show.
TEST(WorstCaseTest, TimeGrowsWithThePixels) {
  Clock clock(1);
  std::vector<Pattern> small = AllPatterns(kWidth / 2, kHeight / 2);
  std::vector<Pattern> large = AllPatterns(kWidth, kHeight);
  ASSERT_EQ(small.size(), large.size());
  for (size_t i = 0; i < small.size(); i += 3) {
    const PaddedImage quarter = Draw(small[i], kWidth / 2, kHeight / 2);
    const PaddedImage whole = Draw(large[i], kWidth, kHeight);
    const double limit = 5 * 4 * clock.Fastest(quarter.view(), kNoLimit, 15);
    EXPECT_LT(clock.Fastest(whole.view(), limit), limit) << large[i].name;
  }
}

// A frame full of 3 x 3 markers that only a second look can read: the holes of their baseline nodes
// are brighter than 6, but not than 7 sixteenths of the contrast.
PaddedImage MarkersOfSecondLooks(int unit, int step, int* markers) {
  Canvas canvas(kWidth, kHeight);
  std::vector<DrawnMarker> all;
  constexpr int kMargin = 16;
  DrawnMarker marker{3, 0, unit};
  for (marker.y = kMargin; marker.y + marker.side() + kMargin < kHeight; marker.y += step) {
    for (marker.x = kMargin; marker.x + marker.side() + kMargin < kWidth; marker.x += step) {
      Draw(marker, &canvas);
      all.push_back(marker);
      marker.id = (marker.id + 1) % 128;
    }
  }
  const BitImage bits = canvas.Bits();
  PaddedImage image(kWidth, kHeight, 0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) image.row(y)[x] = IsWhite(bits, x, y) ? 220 : 30;
  }
  for (const DrawnMarker& m : all) {
    for (int y = m.hole_y(0); y < m.hole_y(0) + unit; ++y) {
      for (const int x : {m.hole_x(0), m.hole_x(0) + 2 * unit}) {
        std::fill_n(image.row(y) + x, unit, static_cast<uint8_t>(30 + 190 * 13 / 32));
      }
    }
  }
  *markers = static_cast<int>(all.size());
  return image;
}

// All second looks of a frame cover a part of it: each of them a white area with its margin.
TEST(WorstCaseTest, SecondLooksAreLimited) {
  const int unit = 5, side = Family(3).white_side() * unit + 2 * kSecondLookMargin;
  const int max_looks = static_cast<int>(kWidth * kHeight / kSecondLookShare / (side * side));
  for (const int step : {80, 260}) {
    int markers;
    const PaddedImage image = MarkersOfSecondLooks(unit, step, &markers);
    Detector detector(MakeOptions(1));
    const size_t found = detector.detect(image.view()).size();
    EXPECT_EQ(DetectorStages(detector).Candidates().size(), 0u);
    EXPECT_EQ(DetectorStages(detector).Doubts().size(), static_cast<size_t>(markers));
    EXPECT_EQ(found, static_cast<size_t>(std::min(markers, max_looks))) << markers << " markers";
  }
}

// The instants of an exposure are as many as pixels that the marker crosses meanwhile, times 40.
TEST(WorstCaseTest, MemoryOfMotionBlurDoesNotGrowWithThePath) {
  const auto bytes = [](double path, double row_time) {
    Scene scene;
    scene.camera.width = 64;
    scene.camera.height = 48;
    scene.camera.fx = scene.camera.fy = 100;
    scene.camera.cx = 32;
    scene.camera.cy = 24;
    scene.blur = 0;
    scene.exposure = 1;
    scene.row_time = row_time;
    SceneMarker marker;
    marker.t = {0, 0, 0.5};
    marker.velocity = {path / 200, 0, 0};
    scene.markers = {marker};
    const PeakBytes peak;
    RenderScene(scene);
    return peak.Get();
  };
  EXPECT_LT(bytes(60, 0), bytes(3, 0) + 100000);
  EXPECT_LT(bytes(60, 1e-9), bytes(3, 1e-9) + 100000);
}

}  // namespace
}  // namespace topotag
