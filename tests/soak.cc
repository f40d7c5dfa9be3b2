// Months of use in minutes: frames of changing size, stride and content through a few detectors
// that live on, and detectors that come and go on many threads. Memory, allocations and file
// descriptors must stay as they are.
//   soak [FRAMES [DETECTORS [DEVICE_DETECTORS]]]

#include <dirent.h>
#include <malloc.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/allocation_hooks.h"
#include "tests/frames.h"
#include "tests/scene_util.h"
#include "topotag/detector.h"
#include "topotag/device.h"
#include "topotag/renderer.h"

namespace {

std::atomic<int64_t> allocations{0};
std::atomic<int64_t> live{0};

}  // namespace

void OnAllocate(void*) {
  ++allocations;
  ++live;
}
void OnFree(void*) { --live; }

namespace topotag {
namespace {

constexpr int kFrames = 600;  // that differ
constexpr int kThreads = 4;   // on which detectors come and go
// What the allocator may keep or give back on its own.
#ifdef TOPOTAG_SANITIZED
// Sanitizers hold freed memory back; what is allocated is counted all the same.
constexpr int64_t kMaxGrowth = 512 << 20;
#else
constexpr int64_t kMaxGrowth = 4 << 20;
#endif
// PoCL's compiler and its threads, whose heaps differ from run to run: no more for 2,000 detectors
// than for 200.
constexpr int64_t kMaxDeviceGrowth = 20 << 20;

int64_t ResidentBytes() {
  int64_t pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    long long size, resident;
    if (std::fscanf(file, "%lld %lld", &size, &resident) == 2) pages = resident;
    std::fclose(file);
  }
  return pages * sysconf(_SC_PAGESIZE);
}

int OpenDescriptors() {
  int count = 0;
  if (DIR* folder = opendir("/proc/self/fd")) {
    while (readdir(folder) != nullptr) ++count;
    closedir(folder);
  }
  return count;
}

struct Usage {
  int64_t resident = ResidentBytes();
  int64_t objects = live;
  int descriptors = OpenDescriptors();
};

bool PrintGrowth(const Usage& before, bool with_device) {
  malloc_trim(0);
  const Usage after;
  std::printf("  resident memory  %.1f MB -> %.1f MB\n", before.resident / 1e6,
              after.resident / 1e6);
  std::printf("  live allocations %lld -> %lld\n", static_cast<long long>(before.objects),
              static_cast<long long>(after.objects));
  std::printf("  descriptors      %d -> %d\n", before.descriptors, after.descriptors);
  return after.resident - before.resident <= kMaxGrowth + (with_device ? kMaxDeviceGrowth : 0) &&
         after.descriptors == before.descriptors &&
         (with_device || after.objects == before.objects);
}

// A small frame with markers that are read, of all families.
Image MarkerFrame(uint64_t seed) {
  test::Random random(seed);
  Scene scene;
  scene.camera = test::PinholeCamera(160, 120, 150);
  SceneMarker marker;
  marker.design.family = Family(3 + static_cast<int>(seed % 3));
  marker.design.id = random.Below(marker.design.family.size());
  marker.R = random.Tilted(random.Uniform(0, 40) * test::kDegree);
  marker.t = {random.Uniform(-0.02, 0.02), random.Uniform(-0.01, 0.01), random.Uniform(0.07, 0.1)};
  scene.markers.push_back(marker);
  scene.seed = seed;
  return RenderScene(scene);
}

class Frames {
 public:
  Frames() {
    for (uint64_t seed = 0; seed < kFrames; ++seed) {
      if (seed % 4 == 0) {
        rendered_.push_back(MarkerFrame(seed));
      } else {
        made_.push_back(MakeFrame(RandomFrameCase(seed)));
      }
    }
    for (const Image& image : rendered_) views_.push_back(image.view());
    for (const GuardedImage& image : made_) views_.push_back(image.view());
  }
  const std::vector<ImageView>& views() const { return views_; }

 private:
  std::vector<Image> rendered_;
  std::vector<GuardedImage> made_;
  std::vector<ImageView> views_;
};

// Every combination of what users switch on, with poses where `with_camera`.
std::vector<Options> OptionSets() {
  std::vector<Options> sets;
  for (int i = 0; i < 5; ++i) {
    Options options;
    options.threads = 1 + i % 2;
    options.camera = test::PinholeCamera(160, 120, 150);
    options.camera->width = options.camera->height = 0;  // for frames of any size
    options.tag_size = 0.05;
    options.hidden_nodes = i == 1 ? 3 : 0;
    options.far = i == 2;
    options.pre_blur = i == 3;
    if (i == 4) options.pose = PoseMode::kPhotometric;
    if (i == 1) options.preset = Preset::kPaper;
    sets.push_back(options);
  }
  return sets;
}

bool SoakFrames(const Frames& frames, int64_t count) {
  std::vector<std::unique_ptr<Detector>> detectors;
  for (const Options& options : OptionSets()) {
    detectors.push_back(std::make_unique<Detector>(options));
  }
  std::vector<Detection> found;
  const std::vector<ImageView>& views = frames.views();
  int64_t markers = 0;
  for (const auto& detector : detectors) {
    for (const ImageView& view : views) detector->detect(view, &found);
  }
  for (const auto& detector : detectors) detector->detect(views[0], &found);
  Random random(1);
  const Usage before;
  const int64_t allocated = allocations;
  const auto start = std::chrono::steady_clock::now();
  for (int64_t i = 0; i < count; ++i) {
    const size_t which = static_cast<size_t>(i) % detectors.size();
    detectors[which]->detect(views[static_cast<size_t>(random.Below(kFrames))], &found);
    markers += static_cast<int64_t>(found.size());
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const int64_t during = allocations - allocated;
  std::printf("%lld frames, %lld markers, %.0f us a frame\n", static_cast<long long>(count),
              static_cast<long long>(markers), 1e6 * seconds / static_cast<double>(count));
  std::printf("  allocations      %lld\n", static_cast<long long>(during));
  const bool is_flat = PrintGrowth(before, false);
  return is_flat && during == 0 && markers > count / 10;
}

// Detectors made, used and destroyed in any order, on one thread of several.
void ComeAndGo(const Frames& frames, BackendKind backend, int count, uint64_t seed,
               std::atomic<int64_t>* markers) {
  std::vector<Options> sets = OptionSets();
  Random random(seed);
  std::vector<std::unique_ptr<Detector>> alive(6);
  std::vector<Detection> found;
  for (int made = 0; made < count;) {
    auto& slot = alive[static_cast<size_t>(random.Below(static_cast<int>(alive.size())))];
    if (slot == nullptr) {
      Options options = sets[static_cast<size_t>(random.Below(static_cast<int>(sets.size())))];
      options.backend = backend;
      slot = std::make_unique<Detector>(options);
      ++made;
    } else if (random.Chance(60)) {
      slot.reset();
    } else {
      slot->detect(frames.views()[static_cast<size_t>(random.Below(kFrames))], &found);
      *markers += static_cast<int64_t>(found.size());
    }
  }
}

bool SoakDetectors(const Frames& frames, BackendKind backend, int count) {
  std::atomic<int64_t> markers{0};
  const auto run = [&](int detectors) {
    std::vector<std::thread> threads;
    for (int t = 0; t < kThreads; ++t) {
      threads.emplace_back([&, t] {
        ComeAndGo(frames, backend, detectors / kThreads, static_cast<uint64_t>(t), &markers);
      });
    }
    for (std::thread& thread : threads) thread.join();
  };
  run(count / 10 + kThreads);
  malloc_trim(0);
  const Usage before;
  run(count);
  std::printf("%d detectors of %s on %d threads, %lld markers\n", count, Name(backend), kThreads,
              static_cast<long long>(markers));
  // Drivers of devices keep things of their own.
  return PrintGrowth(before, backend == BackendKind::kOpenCl);
}

int Main(int argc, char** argv) {
  const auto argument = [&](int i, int64_t value) {
    return argc > i ? std::strtoll(argv[i], nullptr, 10) : value;
  };
  const Frames frames;
  bool is_flat = SoakFrames(frames, argument(1, 1000000));
  const auto detectors = static_cast<int>(argument(2, 10000));
  is_flat = SoakDetectors(frames, BackendKind::kSimd, detectors) && is_flat;
  const auto device_detectors = static_cast<int>(argument(3, 200));
  if (device_detectors == 0 || ListDevices().empty()) {
    std::printf("no OpenCL: without detectors of opencl\n");
  } else {
    is_flat = SoakDetectors(frames, BackendKind::kOpenCl, device_detectors) && is_flat;
  }
  std::printf("%s\n", is_flat ? "flat" : "NOT FLAT");
  return is_flat ? 0 : 1;
}

}  // namespace
}  // namespace topotag

int main(int argc, char** argv) {
  try {
    return topotag::Main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "soak: %s\n", error.what());
  }
  return 1;
}
