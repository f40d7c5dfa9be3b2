// Images of any size, stride and content through the backends that run on the processor, with any
// options. The input chooses what is compared with the scalar backend, bit for bit: the results of
// the stages, detections, or tracks in a video; and with which Highway targets and how many
// threads: all of them take too long.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "tests/detection_text.h"
#include "tests/fuzz/described_case.h"
#include "tests/fuzz/target.h"
#include "tests/random_image.h"
#include "tests/segmentation_parity.h"
#include "tests/simd_targets.h"
#include "topotag/detector.h"
#include "topotag/tracker.h"

#if defined(__SANITIZE_ADDRESS__)
#define TOPOTAG_POISON 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define TOPOTAG_POISON 1
#endif
#endif
#ifdef TOPOTAG_POISON
#include <sanitizer/asan_interface.h>
#endif

namespace topotag::fuzz {
namespace {

/// While it lives, what lies between the rows of an image must not be read.
class PoisonedPadding {
 public:
  explicit PoisonedPadding(const ImageView& image) : image_(image) { Poison(true); }
  PoisonedPadding(const PoisonedPadding&) = delete;
  PoisonedPadding& operator=(const PoisonedPadding&) = delete;
  ~PoisonedPadding() { Poison(false); }

 private:
  void Poison([[maybe_unused]] bool poisoned) {
#ifdef TOPOTAG_POISON
    const size_t padding = static_cast<size_t>(image_.stride - image_.width);
    for (int y = 0; y + 1 < image_.height; ++y) {
      const uint8_t* end = image_.row(y) + image_.width;
      if (poisoned) {
        __asan_poison_memory_region(end, padding);
      } else {
        __asan_unpoison_memory_region(end, padding);
      }
    }
#endif
  }

  ImageView image_;
};

/// What a case compares with the scalar backend.
class Subject {
 public:
  explicit Subject(size_t number) {
    static const std::vector<int64_t> targets = SimdTargets();
    forced_.emplace(targets[number % targets.size()]);
    threads_ = 1 + static_cast<int>(number / targets.size() % kThreads);
  }

  Options Of(Options options) const {
    options.threads = threads_;
    options.backend = BackendKind::kSimd;
    return options;
  }
  [[noreturn]] void Fail(const std::string& name, const std::string& actual,
                         const std::string& expected) const {
    Abort(name + ", " + std::to_string(threads_) + " threads:\n" + actual + "instead of\n" +
          expected);
  }

 private:
  static constexpr size_t kThreads = 3;

  std::optional<ForcedTarget> forced_;
  int threads_;
};

Options Scalar(Options options) {
  options.threads = 1;
  options.backend = BackendKind::kScalar;
  return options;
}

std::vector<Detection> Detected(Detector* detector, const ImageView& image, bool pipelined) {
  if (!pipelined) return detector->detect(image);
  const bool has_size = detector->options().camera || detector->options().roi;
  const ImageView half{image.data, (image.width + 1) / 2, (image.height + 1) / 2, image.stride};
  detector->submit(has_size ? image : half);
  detector->submit(image);
  std::vector<Detection> detections;
  for (int i = 0; i < 2; ++i) Require(detector->collect(&detections), "a frame is not given back");
  return detections;
}

std::string Detections(Detector* detector, const Case& input, bool pipelined) {
  const ImageView image = input.picture.view();
  std::vector<Detection> detections = Detected(detector, image, pipelined);
  std::string text = DetectionText(detections).str();
  if (!input.refined || detections.empty() || !detections[0].pose) return text;
  text += detector->refine(image, &detections[0]) ? "refined\n" : "not refined\n";
  detections.resize(1);
  return text + DetectionText(detections).str();
}

void CompareDetections(const Case& input) {
  const PoisonedPadding poisoned(input.picture.view());
  const Subject subject(input.subject);
  Detector scalar(Scalar(input.options.detection));
  const std::string expected = Detections(&scalar, input, false);
  Detector detector(subject.Of(input.options.detection));
  const std::string actual = Detections(&detector, input, input.pipelined);
  if (actual != expected) subject.Fail(detector.backend(), actual, expected);
}

std::string Tracks(Tracker* tracker, const ImageView& frame) {
  std::string text = DetectionText(tracker->track(frame)).str();
  for (const TrackState& state : tracker->states()) {
    for (const auto value : {state.number, static_cast<uint64_t>(state.age),
                             static_cast<uint64_t>(state.missed), uint64_t{state.in_region}}) {
      text += std::to_string(value) + " ";
    }
  }
  for (const Rect& region : tracker->regions()) {
    for (const int value : {region.x, region.y, region.width, region.height}) {
      text += std::to_string(value) + " ";
    }
  }
  return text + (tracker->searched_whole() ? "whole, lost " : "regions, lost ") +
         std::to_string(tracker->lost()) + "\n";
}

void CompareTracks(const Case& video) {
  const Subject subject(video.subject);
  TrackerOptions options = video.options;
  options.detection = Scalar(video.options.detection);
  Tracker scalar(options);
  options.detection = subject.Of(video.options.detection);
  Tracker tracker(options);
  for (const Shot& shot : video.shots) {
    const PaddedImage frame = Frame(video, shot);
    const PoisonedPadding poisoned(frame.view());
    if (shot.event == Shot::Event::kReset) {
      scalar.reset();
      tracker.reset();
    }
    const std::string expected = Tracks(&scalar, frame.view());
    const std::string actual = Tracks(&tracker, frame.view());
    if (actual != expected) subject.Fail(tracker.backend(), actual, expected);
  }
}

void CompareStages(const Case& input, uint64_t seed) {
  constexpr size_t kSubjects = 3;
  // Their workspaces stay from input to input, of any size.
  static SegmentationParity parity({1, 2});
  const PoisonedPadding poisoned(input.picture.view());
  ThresholdParams threshold;
  threshold.preset = input.options.detection.preset;
  Random random(seed);
  const std::string difference =
      parity.Difference(input.picture.view(), threshold, &random, {input.subject, kSubjects});
  if (!difference.empty()) Abort(difference);
}

Case CaseOf(const std::string& bytes) {
  return DescribedCase(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
}

bool HasMarkers(const Case& input) {
  Detector detector(Scalar(input.options.detection));
  if (input.check != Check::kTracks) return !detector.detect(input.picture.view()).empty();
  return !detector.detect(Frame(input, input.shots[0]).view()).empty();
}

}  // namespace

// Random bytes describe random scenes. In most of those that are kept markers are found: this also
// proves that the painted ones are.
std::vector<std::string> Seeds() {
  constexpr size_t kLength = 160, kWithMarkers = 40, kWithout = 10;
  std::mt19937_64 random(1);
  std::vector<std::string> with, without;
  for (int tries = 0; tries < 1000 && with.size() < kWithMarkers; ++tries) {
    std::string bytes(kLength, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    if (HasMarkers(CaseOf(bytes))) {
      with.push_back(bytes);
    } else if (without.size() < kWithout) {
      without.push_back(bytes);
    }
  }
  Require(with.size() == kWithMarkers, "painted markers are not found");
  with.insert(with.end(), without.begin(), without.end());
  return with;
}

}  // namespace topotag::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace topotag::fuzz;
  HideDevices();
  const Case input = DescribedCase(data, size);
  if (input.check == Check::kStages) CompareStages(input, size);
  if (input.check == Check::kDetections) CompareDetections(input);
  if (input.check == Check::kTracks) CompareTracks(input);
  return 0;
}
