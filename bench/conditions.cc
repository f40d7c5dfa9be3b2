// Hard conditions, each alone: how many markers are found and how exact their poses are, ours
// and AprilTag 3's in the same poses.
//   conditions [--distance 0.4] [--frames 40] [--far] [--hidden N] [--quick]
//              [--format text|json]

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/accuracy_cells.h"
#include "bench/command.h"
#include "bench/hard_conditions.h"
#include "tests/scene_util.h"

namespace topotag::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Arguments {
  std::string format = "text";
  double distance = 0.4;
  int frames = 40;
  bool quick = false;
  bool far = false;
  int hidden = 0;
};

Json Median(std::vector<double> values) {
  if (values.empty()) return nullptr;
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Json Summarize(const std::string& name, const AccuracyCell& cell) {
  Json json{{"condition", name}};
  for (const PoseErrors& system : cell.systems) {
    std::vector<double> positions, rotations;
    for (const auto& error : system.frames) {
      if (!error) continue;
      positions.push_back(1e3 * error->position);
      rotations.push_back(error->rotation / test::kDegree);
    }
    json["systems"][system.name] = {{"frames", system.frames.size()},
                                    {"found", positions.size()},
                                    {"position_mm", Median(positions)},
                                    {"rotation_degrees", Median(rotations)}};
  }
  return json;
}

void PrintRow(const Json& row) {
  std::printf("%-34s", row["condition"].get<std::string>().c_str());
  for (const auto& item : row["systems"].items()) {
    const Json& values = item.value();
    std::printf(" %3d/%d", values["found"].get<int>(), values["frames"].get<int>());
    for (const char* value : {"position_mm", "rotation_degrees"}) {
      if (values[value].is_null()) {
        std::printf("%9s", "-");
      } else {
        std::printf("%9.4f", values[value].get<double>());
      }
    }
  }
  std::printf("\n");
  std::fflush(stdout);
}

int Run(const Arguments& arguments) {
  Options options;
  options.far = arguments.far;
  options.hidden_nodes = arguments.hidden;
  AccuracyBench bench(false, options);
  const bool text = arguments.format == "text";
  Json rows = Json::array();
  const std::vector<HardCondition> conditions = HardConditions();
  for (const HardCondition& condition : conditions) {
    const std::vector<double> tilts = {0, 30, 60};
    AccuracyCell cell = bench.Empty({Family(4), arguments.distance, 0});
    const int frames = arguments.quick ? 1 : arguments.frames;
    for (int frame = 0; frame < frames; ++frame) {
      const uint64_t seed = 1 + static_cast<uint64_t>(frame);
      const double tilt = tilts[static_cast<size_t>(frame) % tilts.size()];
      Scene scene = MakeView({Family(4), arguments.distance, tilt}, seed);
      test::Random random(seed);
      condition.apply(&scene, &random);
      bench.MeasureFrame(scene, &cell);
    }
    rows.push_back(Summarize(condition.name, cell));
    if (!text) continue;
    if (rows.size() == 1) {
      std::printf("found, medians of the position error (mm) and of the rotation's (degrees)\n%34s",
                  "");
      for (const PoseErrors& system : cell.systems) std::printf("%25s", system.name.c_str());
      std::printf("\n");
    }
    PrintRow(rows.back());
  }
  if (!text) std::printf("%s\n", rows.dump(1).c_str());
  return 0;
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Markers in hard conditions, beside AprilTag 3's.", "conditions");
  app.add_option("--distance", arguments.distance, "Metres (default: 0.4)")
      ->check(CLI::Range(0.1, 5.0));
  app.add_option("--frames", arguments.frames,
                 "Frames a condition, tilted by 0, 30 and 60 degrees in turn (default: 40)")
      ->check(CLI::Range(1, 9999));
  app.add_flag("--far", arguments.far, "With Options::far");
  app.add_option("--hidden", arguments.hidden, "Options::hidden_nodes (default: 0)");
  app.add_flag("--quick", arguments.quick, "One frame each");
  AddFormat(&app, &arguments.format);
  CLI11_PARSE(app, argc, argv);
  return Run(arguments);
}

}  // namespace
}  // namespace topotag::bench

int main(int argc, char** argv) {
  return topotag::bench::RunCommand("conditions", topotag::bench::Main, argc, argv);
}
