// How exact poses are: ours and the peers' on rendered frames, beside the Cramer-Rao bound of the
// same frames.
//   accuracy [--family 4x4] [--nodes both] [--frames 40] [--far] [--quick] [--aruco]
//            [--format text|json]

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "bench/accuracy_report.h"
#include "bench/command.h"
#include "host/stop_watch.h"

namespace topotag::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Arguments {
  std::string family = "4x4";
  std::string nodes = "both";
  std::string format = "text";
  int frames = 40;
  bool quick = false;
  bool far = false;
  bool aruco = false;
};

/// Shortest time of the photometric step for a marker whose frame has sides of 60 pixels,
/// microseconds.
Json TimeRefinement(Family family, InnerShape nodes) {
  const View view{family, 695 * kViewSide / 60, 30, nodes};
  const Scene scene = MakeView(view, 2);
  const Image frame = RenderScene(scene);
  Options options;
  options.threads = 1;
  options.camera = scene.camera;
  options.tag_size = scene.markers[0].tag_size;
  Detector detector(options);
  const std::vector<Detection> found = detector.detect(frame.view());
  if (found.empty()) return nullptr;
  double shortest = 1e9;
  for (int run = 0; run < 300; ++run) {
    Detection detection = found[0];
    StopWatch watch;
    if (!detector.refine(frame.view(), &detection)) return nullptr;
    shortest = std::min(shortest, watch.Lap());
  }
  return shortest;
}

int Run(const Arguments& arguments) {
  std::vector<double> distances{0.2, 0.3, 0.4, 0.6, 0.8}, tilts{0, 30, 45, 60, 75};
  int frames = arguments.frames;
  if (arguments.quick) {
    distances = {0.3};
    tilts = {30, 60};
    frames = 4;
  }
  View view;
  view.family = Family::Parse(arguments.family);
  if (arguments.nodes != "both") view.nodes = ParseInnerShape(arguments.nodes);
  Options options;
  options.far = arguments.far;
  AccuracyBench bench(arguments.aruco, options);
  std::vector<AccuracyCell> cells;
  for (const double tilt : tilts) {
    for (const double distance : distances) {
      const uint64_t seed = 1 + 10000 * cells.size();
      view.distance = distance;
      view.tilt = tilt;
      cells.push_back(bench.Measure(view, frames, seed));
      std::fprintf(stderr, "%.1f m, %.0f degrees\n", distance, tilt);
    }
  }
  Json summary = SummarizeAccuracy(cells);
  for (const InnerShape nodes : {InnerShape::kSquare, InnerShape::kCircle}) {
    summary["photometric_us_at_60_px"][Name(nodes)] = TimeRefinement(view.family, nodes);
  }
  const bool text = arguments.format == "text";
  std::printf("%s\n", text ? AccuracyTables(summary).c_str() : summary.dump(1).c_str());
  return 0;
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Pose errors beside AprilTag 3's and the Cramer-Rao bound.", "accuracy");
  app.add_option("--family", arguments.family, "3x3 .. 8x8 (default: 4x4)");
  app.add_option("--nodes", arguments.nodes, "square, circle or both in turn (default: both)")
      ->check(CLI::IsMember({"square", "circle", "both"}));
  app.add_option("--frames", arguments.frames, "Frames a distance and tilt (default: 40)")
      ->check(CLI::Range(2, 9999));
  app.add_flag("--far", arguments.far, "With Options::far");
  app.add_flag("--quick", arguments.quick, "Two cells of four frames");
  app.add_flag("--aruco", arguments.aruco, "OpenCV's ArUco with refined corners, too");
  AddFormat(&app, &arguments.format);
  CLI11_PARSE(app, argc, argv);
  return Run(arguments);
}

}  // namespace
}  // namespace topotag::bench

int main(int argc, char** argv) {
  return topotag::bench::RunCommand("accuracy", topotag::bench::Main, argc, argv);
}
