// Whole detections beside AprilTag 3 and OpenCV's ArUco, in turn, on the same scenes with each
// system's own markers. An iteration is one round of all; the counters are the minimum and the
// median of each system, and the peers' minimum over ours ("x_min/AprilTag d2").
//   peer_bench [--photos=DIR] [options of Google Benchmark]

#include <benchmark/benchmark.h>

#include <cstdio>

#include "bench/comparison.h"
#include "bench/registration.h"
#include "bench/scenes.h"

namespace topotag::bench {
namespace {

void Compare(benchmark::State& state, SceneKind kind, FrameSize size, const Photos& photos,
             const std::vector<Setup>& setups) {
  const BenchScene scene = MakeScene(kind, size, photos);
  Comparison comparison(scene, setups, setups[0].threads);
  for (auto _ : state) comparison.Round();
  double ours = 0;
  for (const Contestant& contestant : comparison.contestants()) {
    const Spread us = SpreadOf(contestant.us);
    if (contestant.ours && (ours == 0 || us.min < ours)) ours = us.min;
    state.counters["min_us/" + contestant.name] = us.min;
    state.counters["median_us/" + contestant.name] = us.median;
    if (!contestant.ours) state.counters["x_min/" + contestant.name] = us.min / ours;
  }
  for (const Contestant& contestant : comparison.contestants()) {
    if (contestant.perfect()) continue;
    const std::string error = contestant.name + " found " + std::to_string(contestant.found) +
                              " of " + std::to_string(contestant.expected) + " markers and " +
                              std::to_string(contestant.wrong) + " that are not there";
    state.SkipWithError(error.c_str());
  }
}

void Register(const Setups& setups, const Photos& photos) {
  for (const auto& list : {setups.missing, MissingPeers()}) {
    for (const std::string& reason : list) std::fprintf(stderr, "left out: %s\n", reason.c_str());
  }
  for (const int threads : {1, 2}) {
    std::vector<Setup> ours;
    for (const Setup& setup : setups.available) {
      if (setup.threads == threads || setup.backend == BackendKind::kScalar) ours.push_back(setup);
    }
    for (const FrameSize size : kFrameSizes) {
      for (const SceneKind kind : kSceneKinds) {
        const std::string name = std::string("compare/threads:") + std::to_string(threads) + "/" +
                                 Name(size) + "/" + Name(kind);
        const auto run = [kind, size, &photos, ours](benchmark::State& state) {
          Compare(state, kind, size, photos, ours);
        };
        benchmark::RegisterBenchmark(name.c_str(), run)
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime();
      }
    }
  }
}

}  // namespace
}  // namespace topotag::bench

int main(int argc, char** argv) {
  using namespace topotag::bench;
  return RunBenchmarks(argc, argv, [](const std::string& folder) {
    static const Photos photos = LoadPhotos(folder);
    Register(FindSetups({1, 2}), photos);
  });
}
