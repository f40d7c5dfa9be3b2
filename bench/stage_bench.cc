// Each stage of the detector: backend x threads x size x scene x memory, as
// "detect/simd/threads:2/1280x960/20_markers/warm", with the mean of each stage as a counter.
//   stage_bench [--photos=DIR] [options of Google Benchmark]

#include <benchmark/benchmark.h>

#include <cstdio>
#include <map>
#include <memory>

#include "bench/registration.h"
#include "bench/scenes.h"
#include "bench/timing.h"

namespace topotag::bench {
namespace {

/// What one benchmark measures.
struct Case {
  Setup setup;
  FrameSize size;
  SceneKind kind;
  bool cold;

  std::string Title() const {
    return std::string("detect/") + Name(setup.backend) +
           "/threads:" + std::to_string(setup.threads) + "/" + Name(size) + "/" + Name(kind) +
           (cold ? "/cold" : "/warm");
  }
};

/// The scene in work: benchmarks of the same scene follow each other.
class Stock {
 public:
  explicit Stock(Photos photos) : photos_(std::move(photos)) {}

  void Prepare(const Case& wanted) {
    const std::string name = Name(wanted.size) + Name(wanted.kind);
    if (name != name_) {
      cold_.reset();
      scene_ = MakeScene(wanted.kind, wanted.size, photos_);
      frame_ = RenderTopoTags(scene_);
      name_ = name;
    }
    if (wanted.cold && !cold_) cold_ = std::make_unique<ColdFrames>(frame_.view(), ColdBytes());
  }

  const BenchScene& scene() const { return scene_; }
  std::vector<ImageView> frames(bool cold) const {
    return cold ? cold_->views() : std::vector<ImageView>{frame_.view()};
  }

 private:
  Photos photos_;
  std::string name_;
  BenchScene scene_;
  Image frame_;
  std::unique_ptr<ColdFrames> cold_;
};

void Detect(benchmark::State& state, const Case& c, Stock* stock) {
  stock->Prepare(c);
  Options options = SceneOptions(stock->scene());
  options.backend = c.setup.backend;
  options.threads = c.setup.threads;
  Detector detector(options);
  const std::vector<ImageView> frames = stock->frames(c.cold);
  std::vector<Detection> found;
  detector.detect(frames.back(), &found);  // sizes the workspace
  StageTimes sum;
  size_t next = 0;
  for (auto _ : state) {
    detector.detect(frames[next], &found);
    next = (next + 1) % frames.size();
    for (const Stage& stage : kStages) sum.*stage.time += detector.times().*stage.time;
  }
  if (found.size() != stock->scene().scene.markers.size()) {
    state.SkipWithError("the markers found are not those of the scene");
  }
  state.SetLabel(c.setup.name);
  state.SetBytesProcessed(state.iterations() * int64_t{c.size.width} * c.size.height);
  for (const Stage& stage : kStages) {
    state.counters[std::string(stage.name) + "_us"] =
        benchmark::Counter(sum.*stage.time, benchmark::Counter::kAvgIterations);
  }
}

void Register(const Setups& setups, Stock* stock) {
  for (const std::string& reason : setups.missing) {
    std::fprintf(stderr, "left out: %s\n", reason.c_str());
  }
  for (const FrameSize size : kFrameSizes) {
    for (const SceneKind kind : kSceneKinds) {
      for (const bool cold : {false, true}) {
        for (const Setup& setup : setups.available) {
          const Case c{setup, size, kind, cold};
          benchmark::RegisterBenchmark(
              c.Title().c_str(), [c, stock](benchmark::State& state) { Detect(state, c, stock); })
              ->Unit(benchmark::kMicrosecond)
              ->UseRealTime();
        }
      }
    }
  }
}

}  // namespace
}  // namespace topotag::bench

int main(int argc, char** argv) {
  using namespace topotag::bench;
  return RunBenchmarks(argc, argv, [](const std::string& photos) {
    static Stock stock(LoadPhotos(photos));
    Register(FindSetups({1, 2}), &stock);
  });
}
