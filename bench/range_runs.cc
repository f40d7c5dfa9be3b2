#include "bench/range_runs.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace topotag::bench {
namespace {

void Count(int right, int all, Recall* recall) {
  ++recall->frames;
  recall->found += right > 0;
  recall->wrong += all - std::min(right, 1);
}

std::string FamilyName(Family family) {
  const std::string n = std::to_string(family.n());
  return n + "x" + n;
}

}  // namespace

RangeBench::RangeBench(const Options& options)
    : families_(options.families), detector_(options), peer_(MakeAprilTag()) {}

RangeRun RangeBench::Measure(const std::string& background, const std::vector<Image>& backgrounds,
                             double tilt, const std::vector<double>& distances, int frames) {
  RangeRun run{background, tilt, distances, {}, {}};
  for (const Family family : families_) run.systems.push_back(FamilyName(family));
  if (peer_) run.systems.push_back(peer_->name());
  run.recall.assign(run.systems.size(), std::vector<Recall>(distances.size()));
  for (size_t d = 0; d < distances.size(); ++d) {
    for (int frame = 0; frame < frames; ++frame) {
      // The seed has nothing to do with the system: all see the same poses.
      const auto millimetres = static_cast<uint64_t>(std::lround(1000 * distances[d]));
      const uint64_t seed = millimetres * 1000 + static_cast<uint64_t>(frame);
      const size_t picture = static_cast<size_t>(frame) + d * static_cast<size_t>(frames);
      const ImageView view =
          backgrounds.empty() ? ImageView{} : backgrounds[picture % backgrounds.size()].view();
      MeasureFrame({families_[0], distances[d], tilt}, seed, view, d, &run);
    }
  }
  return run;
}

void RangeBench::MeasureFrame(const View& seen, uint64_t seed, const ImageView& background,
                              size_t distance, RangeRun* run) {
  View view = seen;
  std::vector<Detection> detections;
  for (size_t i = 0; i < families_.size(); ++i) {
    view.family = families_[i];
    Scene scene = MakeView(view, seed);
    scene.background_image = background;
    detector_.detect(RenderScene(scene).view(), &detections);
    int right = 0;
    for (const Detection& detection : detections) {
      const uint64_t id = scene.markers[0].design.id;
      if (detection.family.n() == view.family.n() && detection.id == id) {
        ++right;
        continue;
      }
      std::fprintf(stderr, "wrong: %s %llu for %s %llu, %s, %.1f m, %.0f degrees, seed %llu\n",
                   FamilyName(detection.family).c_str(),
                   static_cast<unsigned long long>(detection.id), FamilyName(view.family).c_str(),
                   static_cast<unsigned long long>(id), run->background.c_str(), view.distance,
                   view.tilt, static_cast<unsigned long long>(seed));
    }
    Count(right, static_cast<int>(detections.size()), &run->recall[i][distance]);
  }
  if (!peer_) return;
  Scene scene = MakeView(view, seed);
  scene.background_image = background;
  const int id = static_cast<int>(seed % 200);
  std::vector<int> ids;
  peer_->Detect(RenderBitmaps(scene, {peer_->Marker(id)}).view(), &ids);
  Count(static_cast<int>(std::count(ids.begin(), ids.end(), id)), static_cast<int>(ids.size()),
        &run->recall.back()[distance]);
}

}  // namespace topotag::bench
