#include <cmath>
#include <optional>
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
#include "tests/scene_util.h"

namespace topotag::bench::paper {
namespace {

/// One system at one position, over all frames in which it found the marker.
struct Rest {
  int found = 0;
  std::vector<std::vector<PoseSolution>> poses;  ///< [way to a pose][frame]
  std::vector<std::vector<Point2>> points;       ///< [frame][point]
  std::vector<Point2> truth;                     ///< of the points
};

struct SystemRests {
  std::string name;
  Who who = Who::kOurs;
  std::vector<std::string> solvers;
  std::vector<Rest> rests;  ///< one a position
};

Rest Watch(const Scene& place, int frames, System* system) {
  const uint64_t id = system->IdFor(place.seed);
  Rest rest;
  rest.truth = system->TruePoints(place);
  rest.poses.resize(system->solvers().size());
  std::vector<Seen> markers;
  for (int frame = 0; frame < frames; ++frame) {
    Scene scene = place;
    scene.seed += static_cast<uint64_t>(frame);
    system->Locate(system->Render(scene, id).view(), &markers);
    const Seen* seen = FindMarker(scene, id, markers);
    if (seen == nullptr) continue;
    ++rest.found;
    rest.points.push_back(seen->points);
    for (size_t solver = 0; solver < seen->poses.size(); ++solver) {
      if (seen->poses[solver]) rest.poses[solver].push_back(*seen->poses[solver]);
    }
  }
  return rest;
}

std::vector<SystemRests> WatchAll(const Context& context, int frames,
                                  const std::vector<Position>& positions) {
  std::vector<Systems> workers;
  for (int worker = 0; worker < context.threads; ++worker) workers.push_back(MakeAllSystems());
  std::vector<SystemRests> all;
  for (const auto& system : workers[0]) {
    all.push_back(
        {system->name(), system->who(), system->solvers(), std::vector<Rest>(positions.size())});
  }
  const int count = static_cast<int>(all.size() * positions.size());
  context.progress->SetSteps(count);
  ForEachFrame(context, count, [&](int index, int worker) {
    const size_t system = static_cast<size_t>(index) % all.size();
    const size_t position = static_cast<size_t>(index) / all.size();
    all[system].rests[position] = Watch(positions[position].scene, frames,
                                        workers[static_cast<size_t>(worker)][system].get());
  });
  return all;
}

/// Mean over the positions at which a system has a figure, with the largest of them.
MeanMax OverPositions(const std::vector<std::optional<double>>& values) {
  std::vector<double> known;
  for (const auto& value : values) {
    if (value) known.push_back(*value);
  }
  return MeanMaxOf(known);
}

Table PoseTable(const std::vector<SystemRests>& systems) {
  Table table{"jitter",
              "Position and rotation jitter",
              {{"position avg, mm", Better::kLower},
               {"position max, mm", Better::kLower},
               {"rotation avg, degrees", Better::kLower},
               {"rotation max, degrees", Better::kLower},
               {"positions"}},
              {},
              ""};
  for (const Row& published :
       PublishedRows({&Published::position_jitter, &Published::rotation_jitter})) {
    const Cell none = NotGiven();
    table.rows.push_back({Who::kPaper,
                          published.name,
                          {published.cells[0], none, published.cells[1], none, {"", {}}}});
  }
  for (const SystemRests& system : systems) {
    for (size_t solver = 0; solver < system.solvers.size(); ++solver) {
      std::vector<std::optional<double>> position, rotation;
      for (const Rest& rest : system.rests) {
        const auto jitter = JitterOf(rest.poses[solver]);
        position.push_back(jitter ? std::optional(jitter->position) : std::nullopt);
        rotation.push_back(jitter ? std::optional(jitter->rotation) : std::nullopt);
      }
      const MeanMax p = OverPositions(position), r = OverPositions(rotation);
      Row row{system.who, system.name + ", " + system.solvers[solver], {}};
      for (const double value : {p.mean, p.max, r.mean, r.max}) {
        row.cells.push_back(Significant(p.count > 0 ? std::optional(value) : std::nullopt));
      }
      row.cells.push_back({std::to_string(p.count), std::nullopt});
      table.rows.push_back(std::move(row));
    }
  }
  table.note =
      "Root mean square distance from the mean pose at each position; then the mean and the "
      "largest "
      "over the positions at which the system finds its marker at least twice.";
  return table;
}

/// Root mean square distance of what was seen from where it is, pixels.
std::optional<double> ErrorOf(const Rest& rest) {
  double sum = 0;
  int count = 0;
  for (const auto& points : rest.points) {
    for (size_t i = 0; i < points.size(); ++i) {
      sum += std::pow(test::Distance(points[i], rest.truth[i]), 2);
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / count);
}

std::optional<double> PointJitter(const Rest& rest) { return JitterOf(rest.points); }

/// A table with a column for each position.
Table VertexTable(const std::vector<SystemRests>& systems, const std::vector<Position>& positions,
                  std::optional<double> (*figure)(const Rest&)) {
  Table table;
  for (const Position& position : positions) {
    table.columns.push_back({position.name, Better::kLower});
  }
  table.columns.push_back({"mean", Better::kLower});
  table.rows.push_back({Who::kPaper, "all", std::vector<Cell>(table.columns.size(), NotGiven())});
  for (const SystemRests& system : systems) {
    Row row{system.who, system.name, {}};
    std::vector<std::optional<double>> values;
    for (const Rest& rest : system.rests) {
      values.push_back(figure(rest));
      row.cells.push_back(Significant(values.back()));
    }
    const MeanMax mean = OverPositions(values);
    row.cells.push_back(Significant(mean.count > 0 ? std::optional(mean.mean) : std::nullopt));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table JitterTable(const std::vector<SystemRests>& systems, const std::vector<Position>& positions) {
  Table table = VertexTable(systems, positions, PointJitter);
  table.id = "vertex-jitter";
  table.title = "Jitter of vertices at each position, pixels";
  table.note =
      "Root mean square distance of vertices (ours) and corners (peers) from their mean places. "
      "OpenCV's corners are whole pixels unless they are refined: where they are the same in every "
      "frame they do not jitter, however wrong they are; the next table says how wrong.";
  return table;
}

Table PointErrorTable(const std::vector<SystemRests>& systems,
                      const std::vector<Position>& positions) {
  Table table = VertexTable(systems, positions, ErrorOf);
  table.id = "vertex-error";
  table.title = "Error of vertices at each position, pixels";
  table.note = "Root mean square distance from the exact projections, on the same frames.";
  return table;
}

std::string VertexPlot(const std::vector<SystemRests>& systems) {
  std::vector<Line> lines;
  std::vector<std::string> series;
  for (const SystemRests& system : systems) {
    // Ours, and of each peer the dictionary that is used most.
    const bool shown = system.who == Who::kOurs || system.name == "AprilTag 36h11" ||
                       system.name == "ArUco 6x6" || system.name == "ArUco 6x6 subpix";
    if (!shown) continue;
    Line line{system.name, {}, {}};
    for (size_t i = 0; i < system.rests.size(); ++i) {
      const auto error = ErrorOf(system.rests[i]);
      if (!error) continue;
      line.x.push_back(static_cast<double>(i + 1));
      line.y.push_back(*error);
    }
    if (line.x.empty()) continue;
    series.push_back(system.name);
    lines.push_back(std::move(line));
  }
  return Card("Error of vertices", Legend(series) + LinePlot({"position, in the table's order"},
                                                             {"pixels", true}, lines));
}

}  // namespace

Section MeasureJitter(const Context& context) {
  const std::vector<Position> positions = MakePositions(context.Frames(kPositions, 4));
  const int frames = context.Frames(20, 2);
  const std::vector<SystemRests> systems = WatchAll(context, frames, positions);
  Section section;
  section.id = "jitter";
  section.title = "Jitter of markers that rest";
  section.paragraphs = {"The marker rests at " + std::to_string(positions.size()) + " positions, " +
                        std::to_string(frames) +
                        " frames each, in which only the noise (sigma 2 grey levels) changes: "
                        "distances of 0.2 to 0.6 m, tilts of 0, 30, 60 and 75 degrees."};
  section.tables = {PoseTable(systems), JitterTable(systems, positions),
                    PointErrorTable(systems, positions)};
  section.plots = {VertexPlot(systems)};
  const Systems examples = MakeSystems();
  for (const Position& position : positions) {
    section.pictures.push_back(PictureOf(position.name, position.scene, *examples[1]));
  }
  for (const SystemRests& system : systems) {
    for (size_t i = 0; i < positions.size(); ++i) {
      const int found = system.rests[i].found;
      section.data["found"][system.name][positions[i].name] = found;
      if (system.who == Who::kOurs && found < frames) {
        section.broken.push_back(system.name + " at " + positions[i].name + ": found in " +
                                 std::to_string(found) + " of " + std::to_string(frames) +
                                 " frames");
      }
    }
  }
  return section;
}

}  // namespace topotag::bench::paper
