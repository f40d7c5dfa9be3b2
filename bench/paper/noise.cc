#include <string>
#include <utility>
#include <vector>

#include "bench/html.h"
#include "bench/paper/trials.h"
#include "bench/svg.h"

namespace topotag::bench::paper {
namespace {

constexpr double kDistance = 0.4;  // metres
const double kSigmas[] = {2, 5, 10, 20, 30, 50, 80, 115};
const double kQuickSigmas[] = {5, 30};
const double kTilts[] = {0, 30, 45};

/// All systems, and ours with Options::pre_blur after ours without.
Systems MakeNoiseSystems() {
  Systems systems = MakeOurs();
  Options options;
  options.far = true;
  options.pre_blur = true;
  for (const int n : {3, 4, 5}) {
    MarkerDesign design;
    design.family = Family(n);
    systems.push_back(MakeOurs("TopoTag " + design.family.name() + " pre-blur", design, options));
  }
  for (auto& peer : MakePeerSystems()) systems.push_back(std::move(peer));
  return systems;
}

Scene NoisyScene(double sigma, int frame) {
  Scene scene = FreeView(kDistance, kTilts[frame % 3], 1 + static_cast<uint64_t>(frame));
  scene.noise = sigma;
  return scene;
}

/// One family of ours, the others would hide it.
bool Plotted(const SystemTrials& system) {
  return system.who == Who::kPeer || system.name.find("4x4") != std::string::npos;
}

std::string Plot(const std::vector<SystemTrials>& systems, const std::vector<double>& sigmas,
                 int count) {
  std::vector<Line> lines;
  Strings names;
  for (const SystemTrials& system : systems) {
    if (!Plotted(system)) continue;
    Line line{system.name, sigmas, {}, system.who == Who::kPeer};
    for (int i = 0; i < static_cast<int>(sigmas.size()); ++i) {
      const Tally tally = Summarize(system, i * count, count).tally;
      line.y.push_back(100.0 * tally.found / tally.frames);
    }
    names.push_back(system.name);
    lines.push_back(line);
  }
  return Card("Markers found",
              Legend(names) + LinePlot({"noise, sigma in grey levels", true}, {"found, %"}, lines));
}

}  // namespace

Section MeasureNoise(const Context& context) {
  Section section;
  section.id = "noise";
  section.title = "Noise";
  const std::vector<double> sigmas =
      context.quick ? std::vector<double>(std::begin(kQuickSigmas), std::end(kQuickSigmas))
                    : std::vector<double>(std::begin(kSigmas), std::end(kSigmas));
  const int count = context.Frames(12, 1);
  const std::vector<SystemTrials> systems =
      RunTrials(context, MakeNoiseSystems, static_cast<int>(sigmas.size()) * count, [&](int frame) {
        return NoisyScene(sigmas[static_cast<size_t>(frame / count)], frame % count);
      });
  Strings titles;
  for (const double sigma : sigmas) titles.push_back("sigma " + ShortNumber(sigma));
  section.paragraphs = {
      "Gaussian noise of rising sigma is added to each pixel, and the result rounded and clipped "
      "to 0 .. 255; black is 25, white 215. For each sigma " +
      FramesText(count) +
      ", the same poses for all: 0.4 m, tilted by 0, 30 and 45 degrees in turn, turn and "
      "place at random. Nothing else changes, and no system is told; \"pre-blur\" is ours with "
      "that option, which smooths the frame first."};
  section.tables = ConditionTables("noise", "Noise", titles, systems, 0, count);
  section.plots = {Plot(systems, sigmas, count)};
  const Systems shown = MakeOurs();
  for (const double sigma : {sigmas.front(), 30.0, sigmas.back()}) {
    const std::string caption = "TopoTag 4x4, sigma " + ShortNumber(sigma);
    section.pictures.push_back(PictureOf(caption, NoisyScene(sigma, 1), *shown[1]));
  }
  section.data = ConditionData(titles, systems, 0, count);
  section.broken = WrongDetections(systems);
  return section;
}

}  // namespace topotag::bench::paper
