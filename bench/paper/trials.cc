#include "bench/paper/trials.h"

#include <algorithm>
#include <cmath>

#include "bench/paper/statistics.h"
#include "bench/views.h"
#include "tests/scene_util.h"

namespace topotag::bench::paper {
namespace {

constexpr int kMinPictureSide = 150;

Trial Try(const Scene& scene, System* system, std::vector<Seen>* markers) {
  const uint64_t id = system->IdFor(scene.seed);
  system->Locate(system->Render(scene, id).view(), markers);
  Trial trial;
  trial.tally = Judge(scene, id, *markers);
  const Seen* seen = FindMarker(scene, id, *markers);
  if (seen == nullptr || seen->poses.empty() || !seen->poses[0]) return trial;
  const SceneMarker& truth = scene.markers[0];
  const PoseDifference error = Difference(*seen->poses[0], truth.R, truth.t);
  trial.position_mm = error.position;
  trial.rotation_degrees = error.rotation;
  return trial;
}

std::optional<double> Median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<double> Largest(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return *std::max_element(values.begin(), values.end());
}

/// Of a system that has found too little, errors say nothing: the easy frames are left.
Cell ErrorCell(const TrialSummary& summary, const std::optional<double>& error) {
  if (!error || 2 * summary.tally.found < summary.tally.frames) return {};
  return Significant(error);
}

/// To kMinPictureSide at least, by repeating pixels.
Image Enlarged(Image image) {
  const int factor = (kMinPictureSide + image.width() - 1) / image.width();
  if (factor <= 1) return image;
  Image large(factor * image.width(), factor * image.height());
  for (int y = 0; y < large.height(); ++y) {
    for (int x = 0; x < large.width(); ++x) large.row(y)[x] = image.row(y / factor)[x / factor];
  }
  return large;
}

Json OrNull(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

}  // namespace

std::vector<SystemTrials> RunTrials(const Context& context, const std::function<Systems()>& make,
                                    int frames, const MakeTrialScene& scene, int other_steps) {
  std::vector<Systems> workers;
  for (int worker = 0; worker < context.threads; ++worker) workers.push_back(make());
  std::vector<std::vector<Seen>> seen(workers.size());
  std::vector<SystemTrials> results;
  for (const auto& system : workers[0]) {
    results.push_back({system->who(), system->name(), std::vector<Trial>(frames)});
  }
  const int count = static_cast<int>(results.size());
  context.progress->SetSteps(count * frames + other_steps);
  ForEachFrame(context, count * frames, [&](int index, int worker) {
    const int frame = index / count;
    const auto which = static_cast<size_t>(index % count), by = static_cast<size_t>(worker);
    System* system = workers[by][which].get();
    results[which].trials[static_cast<size_t>(frame)] = Try(scene(frame), system, &seen[by]);
  });
  return results;
}

std::vector<std::string> WrongDetections(const std::vector<SystemTrials>& systems) {
  std::vector<std::string> broken;
  for (const SystemTrials& system : systems) {
    if (system.who != Who::kOurs) continue;
    for (size_t frame = 0; frame < system.trials.size(); ++frame) {
      if (system.trials[frame].tally.wrong == 0) continue;
      broken.push_back(system.name + ": wrong detection in frame " + std::to_string(frame));
    }
  }
  return broken;
}

TrialSummary Summarize(const SystemTrials& system, int first, int count) {
  TrialSummary summary;
  std::vector<double> positions, rotations;
  for (int i = first; i < first + count; ++i) {
    const Trial& trial = system.trials[static_cast<size_t>(i)];
    summary.tally.Add(trial.tally);
    if (trial.position_mm) positions.push_back(*trial.position_mm);
    if (trial.rotation_degrees) rotations.push_back(*trial.rotation_degrees);
  }
  summary.position_mm = Median(positions);
  summary.max_position_mm = Largest(positions);
  summary.rotation_degrees = Median(rotations);
  summary.max_rotation_degrees = Largest(rotations);
  return summary;
}

std::vector<Table> ConditionTables(const std::string& id, const std::string& title,
                                   const std::vector<std::string>& titles,
                                   const std::vector<SystemTrials>& systems, int first, int count) {
  Table found{id + "_found", title + ": found", {}, {}, ""};
  Table errors{id + "_errors", title + ": pose errors", {}, {}, ""};
  for (const std::string& condition : titles) {
    found.columns.push_back({condition, Better::kHigher});
    errors.columns.push_back({condition + ", mm", Better::kLower});
  }
  for (const std::string& condition : titles) {
    errors.columns.push_back({condition + ", degrees", Better::kLower});
  }
  found.columns.push_back({"precision", Better::kHigher});
  errors.note =
      "Medians of the found markers' position and rotation errors, where at least half were "
      "found.";
  for (const SystemTrials& system : systems) {
    Row shares{system.who, system.name, {}}, millimetres{system.who, system.name, {}};
    std::vector<Cell> degrees;
    Tally all;
    for (int condition = 0; condition < static_cast<int>(titles.size()); ++condition) {
      const TrialSummary summary = Summarize(system, first + condition * count, count);
      all.Add(summary.tally);
      shares.cells.push_back(Percent(summary.tally.found, summary.tally.frames));
      millimetres.cells.push_back(ErrorCell(summary, summary.position_mm));
      degrees.push_back(ErrorCell(summary, summary.rotation_degrees));
    }
    shares.cells.push_back(Percent(all.found, all.found + all.wrong));
    millimetres.cells.insert(millimetres.cells.end(), degrees.begin(), degrees.end());
    found.rows.push_back(shares);
    errors.rows.push_back(millimetres);
  }
  return {found, errors};
}

Json ConditionData(const std::vector<std::string>& titles, const std::vector<SystemTrials>& systems,
                   int first, int count) {
  Json data = Json::object();
  for (int condition = 0; condition < static_cast<int>(titles.size()); ++condition) {
    Json& row = data[titles[static_cast<size_t>(condition)]];
    for (const SystemTrials& system : systems) {
      const TrialSummary summary = Summarize(system, first + condition * count, count);
      row[system.name] = {{"frames", summary.tally.frames},
                          {"found", summary.tally.found},
                          {"wrong", summary.tally.wrong},
                          {"position_mm", OrNull(summary.position_mm)},
                          {"rotation_degrees", OrNull(summary.rotation_degrees)}};
    }
  }
  return data;
}

Picture PictureOf(const std::string& caption, const Scene& scene, const System& system) {
  const Detection truth = GroundTruth(scene, 0);
  double reach = 0;
  for (const Point2& corner : truth.corners) {
    reach = std::max(reach, 1.25 * test::Distance(corner, truth.center));
  }
  const int half = static_cast<int>(std::ceil(reach));
  const Rect part{static_cast<int>(truth.center.x) - half, static_cast<int>(truth.center.y) - half,
                  2 * half, 2 * half};
  const Image frame = system.Render(scene, system.IdFor(scene.seed));
  return {caption, Enlarged(Crop(frame.view(), part))};
}

std::string FramesText(int count) {
  return std::to_string(count) + (count == 1 ? " frame" : " frames");
}

Scene FreeView(double distance, double tilt, uint64_t seed) {
  return MakeView({Family(4), distance, tilt, InnerShape::kSquare}, seed);
}

}  // namespace topotag::bench::paper
