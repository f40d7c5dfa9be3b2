#include <string>
#include <utility>
#include <vector>

#include "bench/paper/statistics.h"
#include "bench/paper/trials.h"
#include "bench/paper/walk.h"

namespace topotag::bench::paper {
namespace {

constexpr double kDistance = 0.4;  // metres
const double kTilts[] = {0, 30, 60};
constexpr InnerShape kInner[] = {InnerShape::kSquare, InnerShape::kCircle, InnerShape::kHexagon};
constexpr OuterShape kOuter[] = {OuterShape::kSquare, OuterShape::kCircle, OuterShape::kButterfly};

Systems MakeShapes() {
  Options options;
  options.far = true;
  Systems systems;
  for (const int n : {3, 4}) {
    for (const OuterShape outer : kOuter) {
      for (const InnerShape inner : kInner) {
        MarkerDesign design;
        design.family = Family(n);
        design.inner = inner;
        design.outer = outer;
        const std::string name = design.family.name() + ", " + Name(inner) + " in " + Name(outer);
        systems.push_back(MakeOurs(name, design, options));
      }
    }
  }
  return systems;
}

/// Largest distance of each shape, frontal.
std::vector<WalkEnd> WalkAll(const Context& context, const Walk& walk, size_t count) {
  std::vector<Systems> workers;
  for (int worker = 0; worker < context.threads; ++worker) workers.push_back(MakeShapes());
  std::vector<WalkEnd> ends(count);
  ForEachFrame(context, static_cast<int>(count), [&](int index, int worker) {
    const auto which = static_cast<size_t>(index);
    ends[which] = Go(walk, workers[static_cast<size_t>(worker)][which].get());
  });
  return ends;
}

Row ShapeRow(const SystemTrials& system, const WalkEnd& end, int frames, Json* data) {
  const TrialSummary summary = Summarize(system, 0, frames);
  const Tally& tally = summary.tally;
  (*data)[system.name] = {{"frames", tally.frames},
                          {"found", tally.found},
                          {"wrong", tally.wrong + static_cast<int>(end.wrong.size())},
                          {"max_m", 1e-3 * end.distance}};
  return {system.who,
          system.name,
          {Percent(tally.found, tally.frames), Percent(tally.found, tally.found + tally.wrong),
           Significant(summary.position_mm), Significant(summary.max_position_mm),
           Significant(summary.rotation_degrees), Significant(summary.max_rotation_degrees),
           WalkCell(end.distance)}};
}

}  // namespace

Section MeasureShapes(const Context& context) {
  Section section;
  section.id = "shapes";
  section.title = "Shapes";
  const int frames = context.Frames(30, 1);
  const auto view = [](int frame) {
    return FreeView(kDistance, kTilts[frame % 3], 1 + static_cast<uint64_t>(frame));
  };
  const int shapes = static_cast<int>(MakeShapes().size());
  const std::vector<SystemTrials> trials = RunTrials(context, MakeShapes, frames, view, shapes);
  const Walk walk = WalkAway(context, 0);
  const std::vector<WalkEnd> ends = WalkAll(context, walk, trials.size());
  section.paragraphs = {
      "3x3 and 4x4 with each shape of the nodes in each outline of the white area, " +
      FramesText(frames) +
      " each, the same poses for all: 0.4 m, tilted by 0, 30 and 60 degrees in turn, turn "
      "and place at random, blur 0.7 pixels, noise 2. Errors are medians and maxima of the "
      "photometric pose, or of the vertices' where that was rejected. Max distance: frontal, in "
      "steps of " +
      StepsOf(walk) + ", as for the range. The paper's figures for shapes were not at hand."};
  Table table{"shapes",
              "Shapes of nodes and outlines",
              {{"found", Better::kHigher},
               {"precision", Better::kHigher},
               {"position, mm", Better::kLower},
               {"max", Better::kLower},
               {"rotation, degrees", Better::kLower},
               {"max", Better::kLower},
               {"max distance, m", Better::kHigher}},
              {},
              ""};
  for (size_t i = 0; i < trials.size(); ++i) {
    table.rows.push_back(ShapeRow(trials[i], ends[i], frames, &section.data));
  }
  section.tables = {table};
  section.broken = WrongDetections(trials);
  for (size_t i = 0; i < trials.size(); ++i) AddWrong(trials[i].name, ends[i], &section);
  const Systems shown = MakeShapes();
  for (const size_t i : {9, 13, 17}) {
    section.pictures.push_back(PictureOf(shown[i]->name(), view(0), *shown[i]));
  }
  return section;
}

}  // namespace topotag::bench::paper
