#include "bench/profile_sections.h"

#include <cmath>
#include <cstdio>

#include "bench/comparison.h"

namespace topotag::bench {
namespace {

void Progress(const std::string& what) { std::fprintf(stderr, "%s\n", what.c_str()); }

double Rounded(double value, double scale) { return std::round(value * scale) / scale; }

Json SpreadJson(const Spread& spread) {
  return {{"min", Rounded(spread.min, 100)},
          {"median", Rounded(spread.median, 100)},
          {"p99", Rounded(spread.p99, 100)}};
}

int64_t Pixels(FrameSize size) { return int64_t{size.width} * size.height; }

Json StageJson(FrameSize size, SceneKind kind, bool cold, size_t expected, const Measured& m) {
  Json json{{"size", Name(size)},         {"pixels", Pixels(size)},
            {"scene", Name(kind)},        {"memory", cold ? "cold" : "warm"},
            {"backend", m.setup.name},    {"kind", Name(m.setup.backend)},
            {"threads", m.setup.threads}, {"frames", m.frames},
            {"markers", m.markers},       {"expected", expected}};
  const double seconds = 1e-6 * m.stages[kTotal].min;
  json["bytes_per_second"] = std::round(static_cast<double>(Pixels(size)) / seconds);
  for (size_t s = 0; s < kStages.size(); ++s) {
    json["stage_us"][kStages[s].name] = SpreadJson(m.stages[s]);
  }
  return json;
}

Json SystemJson(const Contestant& contestant) {
  return {{"name", contestant.name},
          {"kind", contestant.kind},
          {"ours", contestant.ours},
          {"threads", contestant.threads},
          {"expected", contestant.expected},
          {"found", contestant.found},
          {"wrong", contestant.wrong},
          {"frames", contestant.us.size()},
          {"us", SpreadJson(SpreadOf(contestant.us))}};
}

/// Our setups for a comparison with peers on as many threads; scalar, which has one only, always.
std::vector<Setup> SetupsWith(const Setups& setups, int threads) {
  std::vector<Setup> chosen;
  for (const Setup& setup : setups.available) {
    if (setup.threads == threads || setup.backend == BackendKind::kScalar) chosen.push_back(setup);
  }
  return chosen;
}

Json CompareJson(const BenchScene& scene, const std::vector<Setup>& setups, int threads,
                 double seconds, int rounds) {
  constexpr int kMaxRounds = 100;
  Comparison comparison(scene, setups, threads);
  comparison.Run(seconds, rounds, kMaxRounds);
  Json systems = Json::array();
  for (const Contestant& contestant : comparison.contestants()) {
    systems.push_back(SystemJson(contestant));
    if (contestant.perfect()) continue;
    Progress("  " + contestant.name + " found " + std::to_string(contestant.found) + " of " +
             std::to_string(contestant.expected) + " markers and " +
             std::to_string(contestant.wrong) + " that are not there");
  }
  return systems;
}

}  // namespace

Effort FullEffort() {
  Effort effort;
  effort.sizes.assign(kFrameSizes.begin(), kFrameSizes.end());
  effort.pixel_sizes = {{640, 480},   {1280, 960},  {1920, 1080}, {2560, 1920},
                        {3840, 2160}, {5120, 3840}, {7680, 4320}};
  effort.marker_counts = {0, 10, 20, 50, 100, 150, 200};
  effort.stage = {0.3, 10, 4000};
  effort.cold_bytes = ColdBytes();
  effort.comparison_seconds = 2;
  effort.comparison_rounds = 3;
  effort.throughput_seconds = 0.5;
  effort.opencl_starts = 3;
  return effort;
}

Effort QuickEffort() {
  Effort effort;
  effort.sizes = {{640, 480}};
  effort.pixel_sizes = {{640, 480}, {960, 720}};
  effort.marker_counts = {0, 20};
  effort.stage = {0.01, 2, 20};
  effort.cold_bytes = 1 << 22;
  effort.comparison_seconds = 0;
  effort.comparison_rounds = 1;
  effort.throughput_seconds = 0.02;
  effort.opencl_starts = 1;
  return effort;
}

Json MeasureStages(const Subject& subject) {
  Json section = Json::array();
  for (const FrameSize size : subject.effort.sizes) {
    for (const SceneKind kind : kSceneKinds) {
      Progress("stages: " + Name(size) + ", " + Title(kind));
      const BenchScene scene = MakeScene(kind, size, subject.photos);
      const Image frame = RenderTopoTags(scene);
      for (const bool cold : {false, true}) {
        const ColdFrames copies(frame.view(), cold ? subject.effort.cold_bytes : 0);
        for (const Measured& measured : Measure(subject.setups.available, SceneOptions(scene),
                                                copies.views(), subject.effort.stage)) {
          section.push_back(StageJson(size, kind, cold, scene.scene.markers.size(), measured));
        }
      }
    }
  }
  return section;
}

Json MeasurePeers(const Subject& subject) {
  constexpr int64_t kMaxNoisePixels = 1280 * 960;  // the peers take seconds for larger ones
  Json section = Json::array();
  for (const FrameSize size : subject.effort.sizes) {
    for (const SceneKind kind : kSceneKinds) {
      if (kind == SceneKind::kNoise && Pixels(size) > kMaxNoisePixels) continue;
      Progress("peers: " + Name(size) + ", " + Title(kind));
      const BenchScene scene = MakeScene(kind, size, subject.photos);
      for (const int threads : {1, 2}) {
        section.push_back({{"size", Name(size)},
                           {"pixels", Pixels(size)},
                           {"scene", Name(kind)},
                           {"threads", threads},
                           {"systems", CompareJson(scene, SetupsWith(subject.setups, threads),
                                                   threads, subject.effort.comparison_seconds,
                                                   subject.effort.comparison_rounds)}});
      }
    }
  }
  return section;
}

Json MeasurePixels(const Subject& subject) {
  constexpr int64_t kLargePixels = 10000000;  // one round: the peers take seconds
  Json section = Json::array();
  for (const FrameSize size : subject.effort.pixel_sizes) {
    Progress("pixels: " + Name(size));
    const int rounds = Pixels(size) > kLargePixels ? 1 : subject.effort.comparison_rounds;
    const BenchScene scene = MakeScene(SceneKind::kMarkers, size, subject.photos);
    section.push_back({{"size", Name(size)},
                       {"pixels", Pixels(size)},
                       {"scene", Name(SceneKind::kMarkers)},
                       {"systems", CompareJson(scene, subject.setups.available, 1,
                                               subject.effort.comparison_seconds, rounds)}});
  }
  return section;
}

Json MeasureMarkers(const Subject& subject) {
  Json section = Json::array();
  for (const int count : subject.effort.marker_counts) {
    Progress("markers: " + std::to_string(count));
    section.push_back({{"markers", count},
                       {"systems", CompareJson(MakeCrowd(count), subject.setups.available, 1,
                                               subject.effort.comparison_seconds,
                                               subject.effort.comparison_rounds)}});
  }
  return section;
}

}  // namespace topotag::bench
