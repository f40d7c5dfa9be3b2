#include <string>
#include <utility>
#include <vector>

#include "bench/html.h"
#include "bench/paper/context.h"
#include "bench/paper/published.h"
#include "bench/paper/systems.h"
#include "bench/paper/trials.h"
#include "bench/paper/walk.h"
#include "bench/svg.h"
#include "tests/scene_util.h"

namespace topotag::bench::paper {
namespace {

constexpr double kTilts[] = {0, 45};

/// On the optical axis and upright, to 2 degrees: what is cut off by the frame is then the least.
Walk Towards(const Context& context, double tilt) {
  Walk walk;
  walk.steps = context.quick ? std::vector<int>{-200} : std::vector<int>{-50, -10, -1};
  walk.last = 25;
  walk.frames = context.Frames(4, 1);
  walk.scene = [tilt](int millimetres, int frame) {
    using test::operator*;
    const uint64_t seed = WalkSeed(millimetres, frame);
    test::Random random(seed);
    const Matrix3 turn =
        test::RotationZ((90 * (frame % 4) + random.Uniform(-2, 2)) * test::kDegree);
    return PaperScene(test::RotationX(tilt * test::kDegree) * turn, {0, 0, 1e-3 * millimetres},
                      seed);
  };
  return walk;
}

/// [tilt][0: away, 1: towards] of one system.
struct Ends {
  WalkEnd of[2][2];
};

std::vector<Ends> WalkAll(const Context& context, std::vector<Systems>* workers) {
  const int count = static_cast<int>((*workers)[0].size());
  std::vector<Ends> ends(static_cast<size_t>(count));
  context.progress->SetSteps(4 * count);
  ForEachFrame(context, 4 * count, [&](int index, int worker) {
    const auto which = static_cast<size_t>(index % count);
    const int tilt = index / count / 2, end = index / count % 2;
    System* system = (*workers)[static_cast<size_t>(worker)][which].get();
    const Walk walk = end == 0 ? WalkAway(context, kTilts[tilt]) : Towards(context, kTilts[tilt]);
    ends[which].of[tilt][end] = Go(walk, system);
  });
  return ends;
}

Row OwnRow(const System& system, const Ends& ends) {
  Row row{system.who(), system.name(), {}};
  row.cells.push_back(
      {std::to_string(system.dictionary_size()), static_cast<double>(system.dictionary_size())});
  size_t wrong = 0;
  for (const auto& tilt : ends.of) {
    row.cells.push_back(WalkCell(tilt[1].distance));
    row.cells.push_back(WalkCell(tilt[0].distance));
    wrong += tilt[0].wrong.size() + tilt[1].wrong.size();
  }
  row.cells.push_back(Number(static_cast<double>(wrong), 0));
  return row;
}

Table MakeTable(const Systems& systems, const std::vector<Ends>& ends) {
  Table table{
      "range",
      "Dictionary size, smallest and largest distance",
      {{"IDs", Better::kHigher},
       {"min, m", Better::kLower},
       {"max, m", Better::kHigher},
       {"min at 45 degrees, m", Better::kLower},
       {"max at 45 degrees, m", Better::kHigher},
       {"wrong detections", Better::kLower}},
      PublishedRows({&Published::dictionary, &Published::min_distance, &Published::max_distance}),
      kRobotArm};
  for (Row& row : table.rows) row.cells.resize(table.columns.size());
  for (size_t i = 0; i < systems.size(); ++i) table.rows.push_back(OwnRow(*systems[i], ends[i]));
  return table;
}

std::string Plot(const Systems& systems, const std::vector<Ends>& ends) {
  std::vector<BarGroup> groups;
  for (size_t i = 0; i < systems.size(); ++i) {
    BarGroup group{systems[i]->name(), {}};
    for (const auto& tilt : ends[i].of) group.values.push_back(1e-3 * tilt[0].distance);
    groups.push_back(group);
  }
  const Strings series{"frontal", "45 degrees"};
  return Card("Largest distance", Legend(series) + GroupedBars({"metres"}, series, groups));
}

Json Data(const Systems& systems, const std::vector<Ends>& ends) {
  Json data = Json::object();
  for (size_t i = 0; i < systems.size(); ++i) {
    for (size_t tilt = 0; tilt < 2; ++tilt) {
      const auto& of = ends[i].of[tilt];
      data[systems[i]->name()][tilt == 0 ? "frontal" : "45 degrees"] = {
          {"min_m", 1e-3 * of[1].distance},
          {"max_m", 1e-3 * of[0].distance},
          {"wrong", of[0].wrong.size() + of[1].wrong.size()}};
    }
  }
  return data;
}

}  // namespace

Section MeasureRange(const Context& context) {
  Section section;
  section.id = "range";
  section.title = "Dictionary size and distance";
  std::vector<Systems> workers = MakeSystemsFor(context.threads);
  const std::vector<Ends> ends = WalkAll(context, &workers);
  const Walk away = WalkAway(context, 0), towards = Towards(context, 0);
  section.paragraphs = {
      "Each system's marker of 5 cm goes away from the camera from 0.3 m on, in steps of " +
          StepsOf(away) + ", each step size from where the one before came to: at each distance " +
          FramesText(away.frames) +
          ", the same poses for all, turned at random and within the middle 40 % of the "
          "frame's width and height. Max is the last distance at which, as at all nearer ones "
          "tried, every frame was read. Min is the same towards the camera, in steps of " +
          StepsOf(towards) + ", " + FramesText(towards.frames) +
          " each, on the optical axis and upright to 2 degrees. At 45 degrees: the same with "
          "the marker tilted.",
      "A plain wall, blur 0.7 pixels, noise 2. The dictionaries of ArUco are those of 250 IDs."};
  section.tables = {MakeTable(workers[0], ends)};
  section.plots = {Plot(workers[0], ends)};
  for (size_t i = 0; i < 3; ++i) {
    const int distance = ends[i].of[0][0].distance;
    if (distance == 0) continue;
    const System& system = *workers[0][i];
    section.pictures.push_back(PictureOf(system.name() + " at " + WalkCell(distance).text + " m",
                                         away.scene(distance, 0), system));
  }
  for (size_t i = 0; i < ends.size(); ++i) {
    if (workers[0][i]->who() != Who::kOurs) continue;
    for (const auto& tilt : ends[i].of) {
      for (const WalkEnd& end : tilt) AddWrong(workers[0][i]->name(), end, &section);
    }
  }
  section.data = Data(workers[0], ends);
  return section;
}

}  // namespace topotag::bench::paper
