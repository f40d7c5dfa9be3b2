// Tracking beside detection, frame by frame, on a rendered video of markers that fly about and are
// covered twice: time, wrong IDs, losses and how soon they are made good, what detection finds and
// tracking does not.
//   tracking [--frames 1000] [--size 1280x960] [--markers 1] [--speed 0.6] [--threads 1]
//            [--interval 30] [--repeats 5] [--quick] [--format text|json]

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/command.h"
#include "bench/timing.h"
#include "tests/scene_util.h"
#include "tests/tracking_video.h"
#include "topotag/tracker.h"

namespace topotag::bench {
namespace {

using Json = nlohmann::ordered_json;

// Frames that are rendered, then measured: each comes from memory, as from a camera, but the code
// and the workspace stay in the caches.
constexpr int kBatch = 50;
constexpr double kMaxOffset = 0.25;  // of a marker from where it is, its sides

struct Arguments {
  int frames = 1000;
  std::vector<int> size = {1280, 960};
  int markers = 1;
  double speed = 0.6;
  int threads = 1;
  int interval = TrackerOptions().search_interval;
  int repeats = 5;
  bool quick = false;
  std::string format = "text";
};

/// What one system found in one frame, and its least time.
struct FrameRun {
  std::vector<Detection> detections;
  double us = 1e9;
};

/// What one frame's search was.
enum class Kind { kRegions, kWhole, kBoth };

struct Counts {
  int frames = 0;
  int in_regions = 0, whole = 0, both = 0;
  int visible = 0;       ///< markers that detection found, of all frames
  int tracked = 0;       ///< of these by tracking
  int tracked_more = 0;  ///< by tracking alone
  int wrong = 0;         ///< of both
  int identical = 0;     ///< found in regions, with the vertices that detection found
  int different = 0;
  int losses = 0;
  int latest_regain = 0;  ///< frames in which detection found a lost marker and tracking did not
};

/// A marker of the video, followed by its truth.
struct Followed {
  bool is_tracked = false;
  bool is_lost = false;
  int late = 0;
};

template <typename Call>
double Microseconds(const Call& call) {
  const auto begin = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin)
      .count();
}

const Detection* Find(const std::vector<Detection>& detections, const Detection& truth) {
  const double side = test::Distance(truth.corners[0], truth.corners[2]);
  for (const Detection& detection : detections) {
    if (detection.id == truth.id &&
        test::Distance(detection.center, truth.center) < kMaxOffset * side) {
      return &detection;
    }
  }
  return nullptr;
}

bool HaveSameVertices(const Detection& a, const Detection& b) {
  return std::equal(a.vertices.begin(), a.vertices.end(), b.vertices.begin(), b.vertices.end());
}

class TrackingBench {
 public:
  explicit TrackingBench(const Arguments& arguments)
      : arguments_(arguments), video_(Settings(arguments)), followed_(arguments.markers) {
    TrackerOptions options;
    options.search_interval = arguments.interval;
    options.detection.threads = arguments.threads;
    options.detection.camera = video_.At(0).camera;
    options.detection.tag_size = SceneMarker().tag_size;
    detector_ = std::make_unique<Detector>(options.detection);
    for (int i = 0; i < arguments.repeats; ++i) trackers_.emplace_back(options);
  }

  void Run() {
    for (int begin = 0; begin < arguments_.frames; begin += kBatch) {
      RunBatch(begin, std::min(begin + kBatch, arguments_.frames));
    }
  }

  Json Report() const;

 private:
  static test::VideoSettings Settings(const Arguments& arguments) {
    test::VideoSettings settings;
    settings.width = arguments.size[0];
    settings.height = arguments.size[1];
    settings.frames = arguments.frames;
    settings.markers = arguments.markers;
    settings.max_step = arguments.speed;
    return settings;
  }

  void RunBatch(int begin, int end);
  void Judge(const Scene& scene, Kind kind, const FrameRun& full, const FrameRun& tracked);

  Arguments arguments_;
  test::TrackingVideo video_;
  std::unique_ptr<Detector> detector_;
  std::vector<Tracker> trackers_;  ///< each sees every frame once: the least time of all counts
  std::vector<Followed> followed_;
  Counts counts_;
  std::vector<double> full_us_, tracked_us_;       ///< of all frames
  std::vector<double> full_there_us_, region_us_;  ///< of those that were searched in regions only
};

void TrackingBench::RunBatch(int begin, int end) {
  const auto count = static_cast<size_t>(end - begin);
  std::vector<Image> frames;
  for (int frame = begin; frame < end; ++frame) frames.push_back(RenderScene(video_.At(frame)));
  std::vector<FrameRun> full(count), tracked(count);
  std::vector<Kind> kinds(count);
  for (Tracker& tracker : trackers_) {
    for (size_t i = 0; i < count; ++i) {
      FrameRun& run = tracked[i];
      run.us =
          std::min(run.us, Microseconds([&] { tracker.track(frames[i].view(), &run.detections); }));
      kinds[i] = !tracker.searched_whole()   ? Kind::kRegions
                 : tracker.regions().empty() ? Kind::kWhole
                                             : Kind::kBoth;
    }
    for (size_t i = 0; i < count; ++i) {
      FrameRun& run = full[i];
      run.us = std::min(
          run.us, Microseconds([&] { detector_->detect(frames[i].view(), &run.detections); }));
    }
  }
  for (size_t i = 0; i < count; ++i) {
    Judge(video_.At(begin + static_cast<int>(i)), kinds[i], full[i], tracked[i]);
  }
}

void TrackingBench::Judge(const Scene& scene, Kind kind, const FrameRun& full,
                          const FrameRun& tracked) {
  ++counts_.frames;
  ++(kind == Kind::kRegions ? counts_.in_regions
     : kind == Kind::kWhole ? counts_.whole
                            : counts_.both);
  full_us_.push_back(full.us);
  tracked_us_.push_back(tracked.us);
  if (kind == Kind::kRegions) {
    full_there_us_.push_back(full.us);
    region_us_.push_back(tracked.us);
  }
  size_t right[2] = {0, 0};
  for (size_t m = 0; m < followed_.size(); ++m) {
    const Detection truth = GroundTruth(scene, static_cast<int>(m));
    const Detection* const by_full = Find(full.detections, truth);
    const Detection* const by_track = Find(tracked.detections, truth);
    right[0] += by_full != nullptr;
    right[1] += by_track != nullptr;
    counts_.visible += by_full != nullptr;
    counts_.tracked += by_full != nullptr && by_track != nullptr;
    counts_.tracked_more += by_full == nullptr && by_track != nullptr;
    if (kind == Kind::kRegions && by_full != nullptr && by_track != nullptr) {
      ++(HaveSameVertices(*by_full, *by_track) ? counts_.identical : counts_.different);
    }
    Followed& marker = followed_[m];
    if (marker.is_tracked && by_track == nullptr) {
      ++counts_.losses;
      marker.is_lost = true;
      marker.late = 0;
    }
    marker.is_tracked = by_track != nullptr;
    marker.is_lost &= by_track == nullptr;
    if (marker.is_lost && by_full != nullptr) {
      counts_.latest_regain = std::max(counts_.latest_regain, ++marker.late);
    }
  }
  counts_.wrong +=
      static_cast<int>(full.detections.size() - right[0] + tracked.detections.size() - right[1]);
}

Json TimesJson(const std::vector<double>& full, const std::vector<double>& tracked) {
  const Spread a = SpreadOf(full), b = SpreadOf(tracked);
  return {{"frames", full.size()}, {"detect_us_min", a.min},      {"detect_us_median", a.median},
          {"track_us_min", b.min}, {"track_us_median", b.median}, {"track_us_p99", b.p99}};
}

Json TrackingBench::Report() const {
  Json json;
  json["frames"] = counts_.frames;
  json["size"] = arguments_.size;
  json["markers"] = arguments_.markers;
  json["speed"] = arguments_.speed;
  json["threads"] = arguments_.threads;
  json["search_interval"] = arguments_.interval;
  json["backend"] = detector_->backend();
  json["searched"] = {{"regions", counts_.in_regions},
                      {"whole", counts_.whole},
                      {"regions_then_whole", counts_.both}};
  json["found_by_detect"] = counts_.visible;
  json["found_by_both"] = counts_.tracked;
  json["found_by_track_only"] = counts_.tracked_more;
  json["wrong_ids"] = counts_.wrong;
  json["losses"] = counts_.losses;
  json["frames_to_regain"] = counts_.latest_regain;
  json["in_regions"] = {{"same_vertices", counts_.identical},
                        {"other_vertices", counts_.different}};
  json["time_all"] = TimesJson(full_us_, tracked_us_);
  json["time_regions"] = TimesJson(full_there_us_, region_us_);
  return json;
}

void PrintTimes(const char* title, const Json& times) {
  std::printf("%-28s %5d frames  detect %7.1f %7.1f us  track %6.1f %6.1f us, p99 %6.1f\n", title,
              times["frames"].get<int>(), times["detect_us_min"].get<double>(),
              times["detect_us_median"].get<double>(), times["track_us_min"].get<double>(),
              times["track_us_median"].get<double>(), times["track_us_p99"].get<double>());
}

void PrintText(const Json& json) {
  const auto number = [&](const char* key) { return json[key].get<int>(); };
  const Json& searched = json["searched"];
  std::printf("%d frames of %dx%d, %d marker(s), %s, %d thread(s)\n", number("frames"),
              json["size"][0].get<int>(), json["size"][1].get<int>(), number("markers"),
              json["backend"].get<std::string>().c_str(), number("threads"));
  std::printf("searched: %d in regions, %d wholly, %d in regions and then wholly\n",
              searched["regions"].get<int>(), searched["whole"].get<int>(),
              searched["regions_then_whole"].get<int>());
  std::printf("found: %d by detect, %d of them by track, %d by track alone\n",
              number("found_by_detect"), number("found_by_both"), number("found_by_track_only"));
  std::printf("wrong IDs: %d; losses: %d, found again %d frame(s) later than by detect\n",
              number("wrong_ids"), number("losses"), number("frames_to_regain"));
  std::printf("vertices in regions: %d as detect's to the last bit, %d not\n",
              json["in_regions"]["same_vertices"].get<int>(),
              json["in_regions"]["other_vertices"].get<int>());
  std::printf("time a frame, minimum and median:\n");
  PrintTimes("  all", json["time_all"]);
  PrintTimes("  searched in regions only", json["time_regions"]);
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Tracking beside detection on a rendered video.", "tracking");
  app.add_option("--frames", arguments.frames, "Of the video (default: 1000)")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--size", arguments.size, "WIDTHxHEIGHT in pixels (default: 1280x960)")
      ->delimiter('x')
      ->expected(2)
      ->check(CLI::Range(160, kMaxImageSide));
  app.add_option("--markers", arguments.markers, "In the video (default: 1)")
      ->check(CLI::Range(1, 100));
  app.add_option("--speed", arguments.speed, "At most so many sides a frame (default: 0.6)")
      ->check(CLI::Range(0.0, 5.0));
  app.add_option("--threads", arguments.threads, "Options::threads (default: 1)")
      ->check(CLI::Range(1, kMaxThreads));
  app.add_option("--interval", arguments.interval, "TrackerOptions::search_interval (default: 30)")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--repeats", arguments.repeats, "Least of so many times (default: 5)")
      ->check(CLI::Range(1, 1000));
  app.add_flag("--quick", arguments.quick, "60 frames of 640x480");
  AddFormat(&app, &arguments.format);
  CLI11_PARSE(app, argc, argv);
  if (arguments.quick) {
    arguments.frames = 60;
    arguments.size = {640, 480};
  }
  TrackingBench bench(arguments);
  bench.Run();
  const Json report = bench.Report();
  if (arguments.format == "json") {
    std::printf("%s\n", report.dump(1).c_str());
  } else {
    PrintText(report);
  }
  const bool passed = report["wrong_ids"] == 0 && report["frames_to_regain"] <= 1;
  return passed ? 0 : 1;
}

}  // namespace
}  // namespace topotag::bench

int main(int argc, char** argv) {
  return topotag::bench::RunCommand("tracking", topotag::bench::Main, argc, argv);
}
