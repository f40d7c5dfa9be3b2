// How far markers are read: ours and AprilTag 3's of the same size in the same poses, on a plain
// wall and on photographs.
//   range [--photos DIR] [--frames 10] [--photo-frames 60] [--far] [--quick]
//         [--format text|json]

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/command.h"
#include "bench/photos.h"
#include "bench/range_runs.h"

namespace topotag::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Arguments {
  std::string photos;
  std::string format = "text";
  int frames = 10;
  int photo_frames = 60;
  bool quick = false;
  bool far = false;
};

/// Largest distance up to which every frame was read; 0 where the first was not.
double FullRange(const RangeRun& run, size_t system) {
  double range = 0;
  for (size_t d = 0; d < run.distances.size(); ++d) {
    const Recall& recall = run.recall[system][d];
    if (recall.found < recall.frames) break;
    range = run.distances[d];
  }
  return range;
}

int Wrong(const RangeRun& run, size_t system) {
  int wrong = 0;
  for (const Recall& recall : run.recall[system]) wrong += recall.wrong;
  return wrong;
}

Json ToJson(const RangeRun& run) {
  Json json{{"background", run.background}, {"tilt", run.tilt}, {"distances", run.distances}};
  for (size_t s = 0; s < run.systems.size(); ++s) {
    Json entry{{"name", run.systems[s]},
               {"every_frame_up_to", FullRange(run, s)},
               {"wrong", Wrong(run, s)},
               {"frames", Json::array()},
               {"found", Json::array()}};
    for (const Recall& recall : run.recall[s]) {
      entry["frames"].push_back(recall.frames);
      entry["found"].push_back(recall.found);
    }
    json["systems"].push_back(std::move(entry));
  }
  return json;
}

void PrintTable(const RangeRun& run) {
  std::printf("\n%s, %.0f degrees: share of frames found\n%8s", run.background.c_str(), run.tilt,
              "");
  for (const std::string& system : run.systems) std::printf("%13s", system.c_str());
  for (size_t d = 0; d < run.distances.size(); ++d) {
    std::printf("\n%6.1f m", run.distances[d]);
    for (const auto& recalls : run.recall) {
      std::printf("%13.2f", static_cast<double>(recalls[d].found) / recalls[d].frames);
    }
  }
  std::printf("\n%8s", "every to");
  for (size_t s = 0; s < run.systems.size(); ++s) std::printf("%11.1f m", FullRange(run, s));
  std::printf("\n%8s", "wrong");
  for (size_t s = 0; s < run.systems.size(); ++s) std::printf("%13d", Wrong(run, s));
  std::printf("\n");
}

int Run(const Arguments& arguments) {
  std::vector<double> wall{0.8}, cluttered{0.8};
  int frames = 2, photo_frames = 2;
  if (!arguments.quick) {
    wall.clear();
    for (int decimetres = 6; decimetres <= 32; ++decimetres) wall.push_back(decimetres / 10.0);
    cluttered = {0.8, 1.2, 1.6, 2.0, 2.5};
    frames = arguments.frames;
    photo_frames = arguments.photo_frames;
  }
  const Photos photos = LoadPhotos(arguments.photos);
  Options options;
  options.threads = 1;
  options.far = arguments.far;
  RangeBench bench(options);
  Json runs = Json::array();
  const bool text = arguments.format == "text";
  const auto report = [&](const RangeRun& run) {
    if (text) PrintTable(run);
    runs.push_back(ToJson(run));
    std::fflush(stdout);
  };
  for (const double tilt : {0.0, 45.0}) report(bench.Measure("plain wall", {}, tilt, wall, frames));
  for (const double tilt : {0.0, 45.0}) {
    report(bench.Measure(photos.source, photos.images, tilt, cluttered, photo_frames));
  }
  if (!text) std::printf("%s\n", runs.dump(1).c_str());
  return 0;
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Range beside AprilTag 3's.", "range");
  app.add_option("--photos", arguments.photos,
                 "Folder of photographs for backgrounds (default: procedural clutter)");
  app.add_option("--frames", arguments.frames, "Frames a distance on the wall (default: 10)")
      ->check(CLI::Range(1, 999));
  app.add_option("--photo-frames", arguments.photo_frames,
                 "Frames a distance on photographs (default: 60)")
      ->check(CLI::Range(1, 999));
  app.add_flag("--far", arguments.far, "With Options::far");
  app.add_flag("--quick", arguments.quick, "Two frames at one distance each");
  AddFormat(&app, &arguments.format);
  CLI11_PARSE(app, argc, argv);
  return Run(arguments);
}

}  // namespace
}  // namespace topotag::bench

int main(int argc, char** argv) {
  return topotag::bench::RunCommand("range", topotag::bench::Main, argc, argv);
}
