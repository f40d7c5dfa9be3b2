#include <string>
#include <utility>
#include <vector>

#include "bench/html.h"
#include "bench/paper/context.h"
#include "bench/paper/published.h"
#include "bench/paper/statistics.h"
#include "bench/paper/systems.h"
#include "bench/paper/trajectories.h"
#include "bench/paper/trials.h"
#include "bench/svg.h"

namespace topotag::bench::paper {
namespace {

using Errors = std::vector<std::optional<PoseDifference>>;  // one of each way to a pose

/// What one system says to one frame.
struct Sight {
  Tally tally;
  Errors errors;
};

/// One system on all sequences.
struct SystemSights {
  std::string name;
  Who who = Who::kOurs;
  std::vector<std::string> solvers;
  bool refined = false;                    ///< a second way to corners of a marker that has a row
  std::vector<std::vector<Sight>> sights;  ///< [sequence][frame]
};

Sight Look(const Scene& scene, System* system) {
  const uint64_t id = system->IdFor(scene.seed);
  std::vector<Seen> markers;
  system->Locate(system->Render(scene, id).view(), &markers);
  Sight sight{Judge(scene, id, markers), Errors(system->solvers().size())};
  if (const Seen* seen = FindMarker(scene, id, markers)) {
    const SceneMarker& truth = scene.markers[0];
    for (size_t i = 0; i < seen->poses.size(); ++i) {
      if (seen->poses[i]) sight.errors[i] = Difference(*seen->poses[i], truth.R, truth.t);
    }
  }
  return sight;
}

std::vector<SystemSights> LookAtAll(const Context& context,
                                    const std::vector<Trajectory>& sequences) {
  std::vector<Systems> workers;
  for (int worker = 0; worker < context.threads; ++worker) workers.push_back(MakeAllSystems());
  const size_t frames = sequences[0].scenes.size();
  const size_t first_refined = MakeSystems().size();
  std::vector<SystemSights> all;
  for (const auto& system : workers[0]) {
    SystemSights sights{
        system->name(), system->who(), system->solvers(), all.size() >= first_refined, {}};
    sights.sights.assign(sequences.size(), std::vector<Sight>(frames));
    all.push_back(std::move(sights));
  }
  const int count = static_cast<int>(all.size() * sequences.size() * frames);
  context.progress->SetSteps(count);
  ForEachFrame(context, count, [&](int index, int worker) {
    const size_t system = static_cast<size_t>(index) % all.size();
    const size_t rest = static_cast<size_t>(index) / all.size();
    const size_t sequence = rest % sequences.size(), frame = rest / sequences.size();
    all[system].sights[sequence][frame] =
        Look(sequences[sequence].scenes[frame], workers[static_cast<size_t>(worker)][system].get());
  });
  return all;
}

Table RecallTable(const std::vector<Trajectory>& sequences,
                  const std::vector<SystemSights>& systems) {
  Table table{"recall", "Recall and precision", {}, {}, ""};
  for (const Trajectory& sequence : sequences) {
    table.columns.push_back({"recall, " + sequence.name, Better::kHigher});
  }
  table.columns.push_back({"recall, all", Better::kHigher});
  table.columns.push_back({"precision, all", Better::kHigher});
  for (Row& row : PublishedRows({&Published::recall, &Published::precision})) {
    for (Cell& cell : row.cells) {
      if (cell.text != NotGiven().text) cell.text += " %";
    }
    row.cells.insert(row.cells.begin(), sequences.size(), NotGiven());
    table.rows.push_back(std::move(row));
  }
  for (const SystemSights& system : systems) {
    if (system.refined) continue;
    Row row{system.who, system.name, {}};
    Tally all;
    for (const auto& sights : system.sights) {
      Tally sequence;
      for (const Sight& sight : sights) sequence.Add(sight.tally);
      row.cells.push_back(Percent(sequence.found, sequence.frames));
      all.Add(sequence);
    }
    row.cells.push_back(Percent(all.found, all.frames));
    row.cells.push_back(Percent(all.found, all.found + all.wrong));
    table.rows.push_back(std::move(row));
  }
  table.note =
      "Recall: frames in which the marker was found, with its ID and in its place. Precision: "
      "share "
      "of all detections that are such; everything else that a system reports counts against it. "
      "Each system looks for its own dictionary only.";
  return table;
}

/// Errors of one way to a pose over some sequences.
struct Collected {
  std::vector<double> position, rotation;
};

Collected Collect(const SystemSights& system, size_t solver) {
  Collected all;
  for (const auto& sights : system.sights) {
    for (const Sight& sight : sights) {
      if (!sight.errors[solver]) continue;
      all.position.push_back(sight.errors[solver]->position);
      all.rotation.push_back(sight.errors[solver]->rotation);
    }
  }
  return all;
}

Table ErrorTable(const std::vector<SystemSights>& systems) {
  Table table{"errors",
              "Position and rotation error",
              {{"position avg, mm", Better::kLower},
               {"position max, mm", Better::kLower},
               {"rotation avg, degrees", Better::kLower},
               {"rotation max, degrees", Better::kLower},
               {"poses"}},
              {},
              ""};
  table.rows = PublishedRows({&Published::position_avg, &Published::position_max,
                              &Published::rotation_avg, &Published::rotation_max});
  for (Row& row : table.rows) row.cells.push_back({"", std::nullopt});
  for (const SystemSights& system : systems) {
    for (size_t solver = 0; solver < system.solvers.size(); ++solver) {
      const Collected all = Collect(system, solver);
      const MeanMax position = MeanMaxOf(all.position), rotation = MeanMaxOf(all.rotation);
      Row row{system.who, system.name + ", " + system.solvers[solver], {}};
      for (const double value : {position.mean, position.max, rotation.mean, rotation.max}) {
        row.cells.push_back(Significant(position.count > 0 ? std::optional(value) : std::nullopt));
      }
      row.cells.push_back({std::to_string(position.count), std::nullopt});
      table.rows.push_back(std::move(row));
    }
  }
  table.note =
      "Over all poses of the three sequences. Frames that a system misses are not in its figures. "
      "own: the library's pose; IPPE + LM: OpenCV's solvePnP, then solvePnPRefineLM unless that "
      "makes it worse; subpix: "
      "corners refined by cornerSubPix.";
  return table;
}

/// Mean position errors over one sequence as multiples of that of TopoTag 4x4: our rows first.
std::string RatioPlot(const std::string& sequence_name, size_t sequence,
                      const std::vector<SystemSights>& systems) {
  std::vector<BarGroup> groups;
  double reference = 0;
  for (const SystemSights& system : systems) {
    for (size_t solver = 0; solver < system.solvers.size(); ++solver) {
      std::vector<double> values;
      for (const Sight& sight : system.sights[sequence]) {
        if (sight.errors[solver]) values.push_back(sight.errors[solver]->position);
      }
      const double mean = MeanMaxOf(values).mean;
      if (system.name == "TopoTag 4x4" && solver == 0) reference = mean;
      if (!values.empty()) groups.push_back({system.name + ", " + system.solvers[solver], {mean}});
    }
  }
  if (reference <= 0) return "";
  for (BarGroup& group : groups) group.values[0] /= reference;
  return Card(sequence_name + ": mean position error, times that of TopoTag 4x4, photometric",
              GroupedBars({"times (logarithmic)", true}, {"times"}, groups));
}

std::vector<std::string> Broken(const std::vector<Trajectory>& sequences,
                                const std::vector<SystemSights>& systems) {
  std::vector<std::string> broken;
  for (const SystemSights& system : systems) {
    if (system.who != Who::kOurs) continue;
    for (size_t sequence = 0; sequence < sequences.size(); ++sequence) {
      for (size_t frame = 0; frame < system.sights[sequence].size(); ++frame) {
        const Tally& tally = system.sights[sequence][frame].tally;
        if (tally.found == 1 && tally.wrong == 0) continue;
        broken.push_back(system.name + ", " + sequences[sequence].name + ", frame " +
                         std::to_string(frame) + " (seed " +
                         std::to_string(sequences[sequence].scenes[frame].seed) + "): found " +
                         std::to_string(tally.found) + ", wrong " + std::to_string(tally.wrong));
      }
    }
  }
  return broken;
}

Json Data(const std::vector<Trajectory>& sequences, const std::vector<SystemSights>& systems) {
  Json data = Json::object();
  for (size_t sequence = 0; sequence < sequences.size(); ++sequence) {
    for (const SystemSights& system : systems) {
      for (size_t solver = 0; solver < system.solvers.size(); ++solver) {
        Json position = Json::array(), rotation = Json::array();
        for (const Sight& sight : system.sights[sequence]) {
          const auto& error = sight.errors[solver];
          position.push_back(error ? Json(error->position) : Json());
          rotation.push_back(error ? Json(error->rotation) : Json());
        }
        data[sequences[sequence].name][system.name + ", " + system.solvers[solver]] = {
            {"position_mm", position}, {"rotation_degrees", rotation}};
      }
    }
  }
  return data;
}

}  // namespace

Section MeasureSequences(const Context& context) {
  const std::vector<Trajectory> sequences = MakeSequences(context.Frames(60, 3), *context.photos);
  const std::vector<SystemSights> systems = LookAtAll(context, sequences);
  Section section;
  section.id = "sequences";
  section.title = "Detection and errors over the sequences";
  for (const Trajectory& sequence : sequences) {
    section.paragraphs.push_back(sequence.name + ", " + std::to_string(sequence.scenes.size()) +
                                 " frames: " + sequence.description + ".");
  }
  section.tables = {RecallTable(sequences, systems), ErrorTable(systems)};
  for (size_t i = 0; i < sequences.size(); ++i) {
    section.plots.push_back(RatioPlot(sequences[i].name, i, systems));
  }
  const Systems examples = MakeSystems();
  for (const Trajectory& sequence : sequences) {
    const size_t frame = sequence.scenes.size() / 3;
    for (const size_t system : {size_t{1}, examples.size() - 1}) {
      section.pictures.push_back(PictureOf(sequence.name + ": " + examples[system]->name(),
                                           sequence.scenes[frame], *examples[system]));
    }
  }
  section.data = Data(sequences, systems);
  section.broken = Broken(sequences, systems);
  return section;
}

}  // namespace topotag::bench::paper
