#include "bench/paper/published.h"

#include <algorithm>

namespace topotag::bench::paper {
namespace {

/// As quoted from the paper (Yu, Hu, Dai, "TopoTag: A Robust and Scalable Topological Fiducial
/// Marker System", IEEE TVCG 2021, arXiv 1908.01450) in the notes of this project: its tables of
/// dictionaries and distances, detection, false positives, time, errors, jitter and occlusion. The
/// per-position and per-shape figures were not at hand. Where the paper has one figure for a system
/// with several dictionaries, the name says no more than it does.
std::vector<Published> Collect() {
  std::vector<Published> all;
  const auto add = [&all](const std::string& name) -> Published& {
    all.emplace_back();
    all.back().name = name;
    return all.back();
  };

  Published& topotag = add("TopoTag");
  topotag.recall = topotag.precision = "100";
  topotag.time = "33.638";
  topotag.false_positives = "0";
  topotag.position_avg = "1.011";
  topotag.position_max = "3.289";
  topotag.rotation_avg = "0.019";
  topotag.rotation_max = "0.068";
  topotag.position_jitter = "0.055";
  topotag.rotation_jitter = "0.058";
  topotag.max_occlusion = "10";

  const char* const ranges[][4] = {
      {"TopoTag 3x3", "128", "0.029", "1.204"},     {"TopoTag 4x4", "16384", "0.029", "1.055"},
      {"TopoTag 5x5", "8388608", "0.029", "0.670"}, {"AprilTag-2 36h11", "", "0.042", "0.906"},
      {"AprilTag-1 36h11", "", "0.163", "1.168"},   {"ArUco 16h3", "", "0.117", "1.309"}};
  for (const auto& range : ranges) {
    Published& system = add(range[0]);
    system.dictionary = range[1];
    system.min_distance = range[2];
    system.max_distance = range[3];
  }
  const auto find = [&all](const std::string& name) -> Published& {
    return *std::find_if(all.begin(), all.end(),
                         [&name](const Published& system) { return system.name == name; });
  };
  Published& april2 = find("AprilTag-2 36h11");
  april2.recall = "100";
  april2.precision = "99.99";
  Published& aruco = find("ArUco 16h3");
  aruco.recall = "100";
  aruco.precision = "99.91";
  aruco.false_positives = "146";

  Published& april = add("AprilTag 36h11");
  april.position_avg = "1.402";
  april.position_max = "3.824";
  april.rotation_avg = "0.010";
  april.rotation_max = "0.018";
  april.position_jitter = "0.074";
  april.rotation_jitter = "0.133";
  add("AprilTag 16h5").false_positives = "49321";
  add("AprilTag-1").time = "241 to 251";
  add("AprilTag-2").time = "13.4";

  Published& all_aruco = add("ArUco");
  all_aruco.time = "54 to 56";
  all_aruco.position_avg = "8 to 10";
  all_aruco.position_max = "22 to 27";

  Published& kit = add("ARToolKit");
  kit.recall = "99.99";
  kit.precision = "99.88";
  kit.time = "5.9";
  kit.false_positives = "9756";
  Published& plus = add("ARToolKitPlus");
  plus.time = "9.3";
  plus.false_positives = "0";
  Published& rune = add("RuneTag");
  rune.recall = "0.281";
  rune.time = "456";
  rune.max_occlusion = "30";
  Published& chroma = add("ChromaTag");
  chroma.recall = "9.1";
  chroma.time = "9.1";
  add("reacTIVision").false_positives = "348";
  add("all others").max_occlusion = "below 10";
  return all;
}

}  // namespace

const std::vector<Published>& PublishedFigures() {
  static const std::vector<Published> figures = Collect();
  return figures;
}

std::vector<Row> PublishedRows(const std::vector<std::string Published::*>& members) {
  std::vector<Row> rows;
  for (const Published& system : PublishedFigures()) {
    Row row{Who::kPaper, system.name, {}};
    bool known = false;
    for (const auto member : members) {
      const std::string& text = system.*member;
      known = known || !text.empty();
      row.cells.push_back(text.empty() ? NotGiven() : Cell{text, std::nullopt});
    }
    if (known) rows.push_back(row);
  }
  return rows;
}

}  // namespace topotag::bench::paper
