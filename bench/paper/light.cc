#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "bench/hard_conditions.h"
#include "bench/paper/trials.h"

namespace topotag::bench::paper {
namespace {

using test::Random;

constexpr double kDistance = 0.4;    // metres
constexpr double kExposure = 0.005;  // seconds
constexpr double kRowTime = 30e-6;   // seconds
const double kTilts[] = {0, 30, 45};

/// One kind of light or motion in several degrees.
struct Group {
  std::string id, title;
  std::vector<HardCondition> degrees;
};

HardCondition Gain(const std::string& name, double gain) {
  return {name, [gain](Scene* scene, Random*) { scene->lighting.gain = gain; }};
}

HardCondition Shaded(const std::string& name, double factor, double penumbra) {
  return {name, [factor, penumbra](Scene* scene, Random* random) {
            AddShadow(factor, penumbra, scene, random);
          }};
}

HardCondition Moved(const std::string& name, double pixels) {
  return {name, [pixels](Scene* scene, Random* random) {
            scene->exposure = kExposure;
            scene->row_time = kRowTime;
            Move(pixels, kExposure, scene, random);
          }};
}

HardCondition Highlighted(const std::string& name, double level) {
  return {name, [level](Scene* scene, Random* random) { AddHighlight(level, scene, random); }};
}

HardCondition Defocused(const std::string& name, double sigma) {
  return {name, [sigma](Scene* scene, Random*) { scene->blur = sigma; }};
}

/// In quick mode one degree of each.
std::vector<Group> Groups(bool quick) {
  std::vector<Group> groups = {
      {"dark",
       "Dark",
       {Gain("white 86", 0.4), Gain("white 43", 0.2), Gain("white 22", 0.1),
        Gain("white 11", 0.05)}},
      {"bright",
       "Bright",
       {Gain("white 258", 1.2), Gain("white 290", 1.35), Gain("white 344", 1.6),
        Gain("white 430", 2)}},
      {"shadow",
       "Shadow's edge across the marker",
       {Shaded("to 50 %", 0.5, 0), Shaded("to 30 %", 0.3, 0), Shaded("to 20 %", 0.2, 0),
        Shaded("to 20 %, 10 px wide", 0.2, 10)}},
      {"motion",
       "Motion blur with rolling shutter",
       {Moved("3 px", 3), Moved("4.5 px", 4.5), Moved("6 px", 6), Moved("8 px", 8)}},
      {"highlight",
       "Highlight",
       {Highlighted("+100", 100), Highlighted("+150", 150), Highlighted("+200", 200)}},
      {"defocus",
       "Defocus",
       {Defocused("sigma 1.5 px", 1.5), Defocused("2 px", 2), Defocused("2.5 px", 2.5),
        Defocused("3 px", 3)}}};
  if (quick) {
    for (Group& group : groups) group.degrees = {HardCondition(group.degrees[1])};
  }
  return groups;
}

Scene HardScene(const HardCondition& condition, int frame) {
  const uint64_t seed = 1 + static_cast<uint64_t>(frame);
  Scene scene = FreeView(kDistance, kTilts[frame % 3], seed);
  Random random(seed);
  condition.apply(&scene, &random);
  return scene;
}

}  // namespace

Section MeasureLight(const Context& context) {
  Section section;
  section.id = "light";
  section.title = "Light and motion";
  const std::vector<Group> groups = Groups(context.quick);
  const int count = context.Frames(12, 1);
  std::vector<const HardCondition*> conditions;
  for (const Group& group : groups) {
    for (const HardCondition& degree : group.degrees) conditions.push_back(&degree);
  }
  const std::vector<SystemTrials> systems =
      RunTrials(context, MakeSystems, static_cast<int>(conditions.size()) * count, [&](int frame) {
        return HardScene(*conditions[static_cast<size_t>(frame / count)], frame % count);
      });
  section.paragraphs = {
      "For each condition " + FramesText(count) +
          ", the same poses for all: 0.4 m, tilted by 0, 30 and 45 degrees in turn, turn "
          "and "
          "place at random; noise of 2 grey levels. Dark and bright: all light times a factor, "
          "clipped at 255; columns say what white then is. The edge of the shadow crosses the "
          "marker in any direction, what is in it keeps the share of light that the column says.",
      "Motion: in any direction, by so many pixels while a row is exposed (5 ms), the rows one "
      "after the other (30 us a row): a marker of 90 pixels is skewed by half as much as it is "
      "blurred. The true pose is that in the middle of the exposure of the row that shows the "
      "marker's centre. A highlight is a spot of 12 pixels sigma, up to 30 pixels from the "
      "marker's centre along either axis, whose level is added. Defocus: sigma of a Gaussian."};
  const Systems shown = MakeOurs();
  int first = 0;
  for (const Group& group : groups) {
    std::vector<std::string> titles;
    for (const HardCondition& degree : group.degrees) titles.push_back(degree.name);
    for (Table& table : ConditionTables(group.id, group.title, titles, systems, first, count)) {
      section.tables.push_back(std::move(table));
    }
    section.data[group.id] = ConditionData(titles, systems, first, count);
    const HardCondition& last = group.degrees.back();
    section.pictures.push_back(
        PictureOf(group.title + ", " + last.name, HardScene(last, 1), *shown[1]));
    first += count * static_cast<int>(titles.size());
  }
  section.broken = WrongDetections(systems);
  return section;
}

}  // namespace topotag::bench::paper
