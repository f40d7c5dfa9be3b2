// Time of each stage of a detector on rendered frames of 1280x960.

#include <benchmark/benchmark.h>

#include <cmath>

#include "tests/scene_util.h"
#include "topotag/detector.h"
#include "topotag/renderer.h"

namespace topotag {
namespace {

// `count` markers of 4x4 in rows of five on a noisy wall.
Scene Wall(int count) {
  Scene scene;
  scene.camera = test::PinholeCamera(1280, 960, 695);
  test::Random random(1);
  for (int i = 0; i < count; ++i) {
    SceneMarker marker;
    marker.design.id = random.Below(marker.design.family.size());
    marker.t = {(i % 5 - 2) * 0.09, (i / 5 - (count - 1) / 10.0) * 0.09, 0.4};
    marker.R = random.Tilted(random.Uniform(0, 0.7));
    scene.markers.push_back(marker);
  }
  return scene;
}

void Detect(benchmark::State& state) {
  const Scene scene = Wall(static_cast<int>(state.range(0)));
  const Image image = RenderScene(scene);
  Options options;
  options.camera = scene.camera;
  options.tag_size = 0.05;
  Detector detector(options);
  std::vector<Detection> found;
  StageTimes sum;
  for (auto _ : state) {
    detector.detect(image.view(), &found);
    const StageTimes& t = detector.times();
    sum.threshold += t.threshold;
    sum.binarize += t.binarize;
    sum.label += t.label;
    sum.tree += t.tree;
    sum.decode += t.decode;
    sum.vertices += t.vertices;
    sum.pose += t.pose;
  }
  if (found.size() != scene.markers.size()) state.SkipWithError("a marker was not found");
  const auto mean = [](double value) {
    return benchmark::Counter(value, benchmark::Counter::kAvgIterations);
  };
  state.SetLabel(detector.backend());
  state.counters = {{"threshold", mean(sum.threshold)},
                    {"binarize", mean(sum.binarize)},
                    {"label", mean(sum.label)},
                    {"tree", mean(sum.tree)},
                    {"decode", mean(sum.decode)},
                    {"vertices", mean(sum.vertices)},
                    {"pose", mean(sum.pose)}};
}
BENCHMARK(Detect)->Arg(0)->Arg(1)->Arg(20)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace topotag
