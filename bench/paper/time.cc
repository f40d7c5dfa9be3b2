#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/html.h"
#include "bench/paper/context.h"
#include "bench/paper/published.h"
#include "bench/paper/systems.h"
#include "bench/paper/trajectories.h"
#include "bench/peers.h"
#include "bench/svg.h"

namespace topotag::bench::paper {
namespace {

using Clock = std::chrono::steady_clock;

/// Something that is timed on the frames of one system's markers.
struct Runner {
  std::string name;
  Who who = Who::kOurs;
  size_t system = 0;  ///< whose markers
  std::function<void(const ImageView&)> run;
  std::vector<double> milliseconds;  ///< mean of each kind of frames
};

/// Frames of one kind, of each system.
using Frames = std::vector<std::vector<Image>>;

double Milliseconds(Clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

/// The least of several runs on each frame, the machine's disturbances left out; mean over them.
double MeanOfMinima(const std::vector<Image>& frames, int rounds,
                    const std::function<void(const ImageView&)>& run) {
  double sum = 0;
  for (const Image& frame : frames) {
    double least = std::numeric_limits<double>::infinity();
    run(frame.view());
    for (int round = 0; round < rounds; ++round) {
      const Clock::time_point start = Clock::now();
      run(frame.view());
      least = std::min(least, Milliseconds(Clock::now() - start));
    }
    sum += least;
  }
  return sum / static_cast<double>(frames.size());
}

std::vector<Runner> MakeRunners(const Systems& systems, const Systems& by_default,
                                const std::vector<std::unique_ptr<Peer>>& fast_peers) {
  std::vector<Runner> runners;
  const auto add = [&runners](const std::string& name, size_t index, System* system,
                              size_t solver) {
    runners.push_back({name,
                       system->who(),
                       index,
                       [system, solver](const ImageView& frame) { system->Run(frame, solver); },
                       {}});
  };
  for (size_t i = 0; i < by_default.size(); ++i) {
    add(systems[i]->name() + ", vertices", i, by_default[i].get(), 1);
    add(systems[i]->name() + ", photometric", i, by_default[i].get(), 0);
    add(systems[i]->name() + ", far, photometric", i, systems[i].get(), 0);
  }
  for (size_t i = by_default.size(); i < systems.size(); ++i) {
    add(systems[i]->name(), i, systems[i].get(), 0);
    for (const auto& peer : fast_peers) {
      const std::string name = systems[i]->name();
      const bool same = (name == "AprilTag 36h11" && peer->name() == "AprilTag d2") ||
                        (name == "ArUco 6x6" && peer->name() == "ArUco3");
      if (!same) continue;
      Peer* fast = peer.get();
      runners.push_back({name + " (" + peer->name() + ")",
                         Who::kPeer,
                         i,
                         [fast](const ImageView& frame) {
                           std::vector<int> ids;
                           fast->Detect(frame, &ids);
                         },
                         {}});
    }
  }
  return runners;
}

Frames RenderFrames(const Context& context, const Trajectory& sequence, const Systems& systems) {
  Frames frames(systems.size());
  for (auto& of_system : frames) of_system.resize(sequence.scenes.size());
  ForEachFrame(
      context, static_cast<int>(systems.size() * sequence.scenes.size()), [&](int index, int) {
        const size_t system = static_cast<size_t>(index) % systems.size();
        const size_t frame = static_cast<size_t>(index) / systems.size();
        const Scene& scene = sequence.scenes[frame];
        frames[system][frame] = systems[system]->Render(scene, systems[system]->IdFor(scene.seed));
      });
  return frames;
}

Systems OursByDefault() {
  Systems systems;
  for (const int n : {3, 4, 5}) {
    MarkerDesign design;
    design.family = Family(n);
    systems.push_back(MakeOurs("TopoTag " + design.family.name(), design, Options()));
  }
  return systems;
}

}  // namespace

Section MeasureTime(const Context& context) {
  const std::vector<Trajectory> sequences = MakeSequences(context.Frames(6, 1), *context.photos);
  const Systems systems = MakeSystems(), by_default = OursByDefault();
  PeerSetup setup;
  setup.min_side = 55;  // of the farthest marker in the sequences
  const auto fast_peers = MakePeers(setup);
  std::vector<Runner> runners = MakeRunners(systems, by_default, fast_peers);
  const size_t frames = sequences[0].scenes.size();
  const size_t renders = systems.size() * frames;
  context.progress->SetSteps(static_cast<int>((renders + runners.size()) * sequences.size()));
  for (const Trajectory& sequence : sequences) {
    const Frames rendered = RenderFrames(context, sequence, systems);
    for (Runner& runner : runners) {
      const int rounds = runner.who == Who::kOurs ? context.Frames(20, 3) : context.Frames(4, 1);
      runner.milliseconds.push_back(MeanOfMinima(rendered[runner.system], rounds, runner.run));
      context.progress->Step();
    }
  }
  Section section;
  section.id = "time";
  section.title = "Time";
  Table table{"time", "Milliseconds a frame of 1280 x 960, one thread, poses included", {}, {}, ""};
  for (const Trajectory& sequence : sequences) {
    table.columns.push_back({sequence.name, Better::kLower});
  }
  table.columns.push_back({"mean", Better::kLower});
  for (Row& row : PublishedRows({&Published::time})) {
    row.cells.insert(row.cells.begin(), sequences.size(), NotGiven());
    table.rows.push_back(std::move(row));
  }
  std::vector<BarGroup> bars;
  for (const Runner& runner : runners) {
    Row row{runner.who, runner.name, {}};
    double mean = 0;
    for (const double value : runner.milliseconds) {
      row.cells.push_back(Number(value, 3));
      mean += value / static_cast<double>(runner.milliseconds.size());
    }
    row.cells.push_back(Number(mean, 3));
    table.rows.push_back(std::move(row));
    bars.push_back({runner.name, {mean}});
  }
  table.note =
      "The least of several runs on each frame, mean over the frames. The paper's times were taken "
      "on an i7-7700HQ. AprilTag d2: quad_decimate 2; ArUco3: told how small a marker may be; both "
      "without poses.";
  section.tables = {table};
  section.plots = {Card("Time a frame, mean of the sequences",
                        GroupedBars({"ms (logarithmic)", true}, {"ms"}, bars))};
  return section;
}

}  // namespace topotag::bench::paper
