// The sections of the profile that need threads or processes of their own.
#include <stdlib.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "bench/profile_sections.h"
#include "host/stop_watch.h"

namespace topotag::bench {
namespace {

namespace fs = std::filesystem;

/// Frames a second of `count` detectors, each on a thread and a frame of its own.
double FramesPerSecond(const BenchScene& scene, const Setup& setup, int count, double seconds) {
  Options options = SceneOptions(scene);
  options.backend = setup.backend;
  const Image frame = RenderTopoTags(scene);
  std::atomic<int> ready{0};
  std::atomic<bool> stop{false};
  std::vector<int64_t> frames(static_cast<size_t>(count));
  std::vector<std::thread> threads;
  threads.reserve(frames.size());
  for (int i = 0; i < count; ++i) {
    threads.emplace_back([&, i] {
      const ColdFrames copy(frame.view(), 0);
      Detector detector(options);
      std::vector<Detection> found;
      detector.detect(copy.views()[0], &found);
      ready.fetch_add(1);
      while (ready.load() < count) std::this_thread::yield();
      int64_t done = 0;
      for (; !stop.load(std::memory_order_relaxed); ++done) {
        detector.detect(copy.views()[0], &found);
      }
      frames[static_cast<size_t>(i)] = done;
    });
  }
  while (ready.load() < count) std::this_thread::yield();
  StopWatch watch;
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  stop.store(true);
  const double elapsed = 1e-6 * watch.Lap();
  for (std::thread& thread : threads) thread.join();
  int64_t total = 0;
  for (const int64_t n : frames) total += n;
  return static_cast<double>(total) / elapsed;
}

/// A folder of its own that is removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_((fs::temp_directory_path() / "topotag_profile_XXXXXX").string()) {
    if (mkdtemp(path_.data()) == nullptr) {
      throw Error(ErrorCode::kFile, path_ + ": folder cannot be created");
    }
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Runs TimeOpenClStart in a process whose caches of compiled kernels are in the folder.
Json StartProcess(const std::string& program, const std::string& folder) {
  const std::string command = "TOPOTAG_CACHE_DIR='" + folder + "/topotag' POCL_CACHE_DIR='" +
                              folder + "/pocl' '" + program + "' --time-opencl-start";
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw Error(ErrorCode::kFile, program + ": cannot be started");
  char line[256] = "";
  const bool read = std::fgets(line, sizeof line, pipe) != nullptr;
  if (pclose(pipe) != 0 || !read) {
    throw Error(ErrorCode::kDevice, "the process that starts opencl has failed");
  }
  return Json::parse(line);
}

}  // namespace

Json MeasureThroughput(const Subject& subject) {
  constexpr int kRepetitions = 3;  // in turn; the best of each counts
  Json section = Json::array();
  for (const FrameSize size : {FrameSize{640, 480}, FrameSize{1280, 960}}) {
    for (const SceneKind kind : {SceneKind::kOneMarker, SceneKind::kMarkers}) {
      std::fprintf(stderr, "throughput: %s, %s\n", Name(size).c_str(), Title(kind));
      const BenchScene scene = MakeScene(kind, size, subject.photos);
      for (const Setup& setup : subject.setups.available) {
        if (setup.threads != 1) continue;
        double fps[2] = {0, 0};
        for (int i = 0; i < kRepetitions; ++i) {
          for (int n = 0; n < 2; ++n) {
            fps[n] = std::max(
                fps[n], FramesPerSecond(scene, setup, n + 1, subject.effort.throughput_seconds));
          }
        }
        section.push_back({{"size", Name(size)},
                           {"scene", Name(kind)},
                           {"backend", setup.name},
                           {"kind", Name(setup.backend)},
                           {"one_fps", std::round(fps[0])},
                           {"two_fps", std::round(fps[1])}});
      }
    }
  }
  return section;
}

Json MeasureOpenClStart(const Subject& subject, const std::string& program) {
  Json section = Json::array();
  const auto is_opencl = [](const Setup& s) { return s.backend == BackendKind::kOpenCl; };
  const std::vector<Setup>& setups = subject.setups.available;
  if (std::none_of(setups.begin(), setups.end(), is_opencl)) return section;
  for (int i = 0; i < subject.effort.opencl_starts; ++i) {
    std::fprintf(stderr, "opencl start %d\n", i + 1);
    const TemporaryFolder folder;
    for (const char* cache : {"empty", "filled"}) {
      Json start{{"cache", cache}};
      start.update(StartProcess(program, folder.path()));
      section.push_back(std::move(start));
    }
  }
  return section;
}

void TimeOpenClStart() {
  const BenchScene scene = MakeScene(SceneKind::kOneMarker, {1280, 960}, {});
  const Image frame = RenderTopoTags(scene);
  Options options = SceneOptions(scene);
  options.backend = BackendKind::kOpenCl;
  StopWatch watch;
  Detector detector(options);
  const double construct = watch.Lap();
  detector.detect(frame.view());
  const Json json{{"construct_us", std::round(construct)},
                  {"first_frame_us", std::round(watch.Lap())}};
  std::printf("%s\n", json.dump().c_str());
}

}  // namespace topotag::bench
