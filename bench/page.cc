#include "bench/page.h"

#include <algorithm>
#include <vector>

#include "bench/html.h"
#include "bench/scenes.h"
#include "bench/svg.h"
#include "bench/timing.h"

namespace topotag::bench {
namespace {

using Json = nlohmann::ordered_json;

std::string Text(const Json& json) {
  return json.is_string() ? json.get<std::string>() : json.dump();
}

/// In the order of their first appearance.
Strings Distinct(const Json& section, const char* key) {
  Strings values;
  for (const Json& entry : section) {
    const std::string value = Text(entry[key]);
    if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
  }
  return values;
}

std::string SceneTitle(const std::string& name) {
  for (const SceneKind kind : kSceneKinds) {
    if (name == Name(kind)) return Title(kind);
  }
  return name;
}

std::string Threads(const Json& entry) {
  return entry["threads"] == 1 ? "" : " x" + Text(entry["threads"]);
}

std::string Microseconds(double us) {
  return us < 1000 ? ShortNumber(us) + " us" : ShortNumber(us / 1000) + " ms";
}

std::string MachineSection(const Json& profile) {
  std::vector<Strings> rows;
  for (const auto& item : profile["machine"].items()) {
    rows.push_back({Escape(item.key()), Escape(Text(item.value()))});
  }
  const auto add = [&](const char* key, const char* label) {
    for (const Json& value : profile[key]) rows.push_back({label, Escape(Text(value))});
  };
  add("backends", "backend");
  add("peers_used", "peer");
  rows.push_back({"backgrounds", Escape(Text(profile["scenes"]["backgrounds"]))});
  rows.push_back({"cold frames", Escape(Text(profile["scenes"]["cold_mib"]) + " MiB in rotation")});
  for (const Json& value : profile["missing"]) {
    rows.push_back({"left out", "<span class='bad'>" + Escape(Text(value)) + "</span>"});
  }
  return Table({"measured on", ""}, rows, "text");
}

Strings StageNames() {
  Strings names;
  for (size_t s = 0; s < kTotal; ++s) names.push_back(kStages[s].name);
  return names;
}

Bar StageBar(const Json& entry) {
  Bar bar;
  bar.label = Text(entry["kind"]) + Threads(entry) + " " + Text(entry["memory"]);
  for (const std::string& stage : StageNames()) {
    bar.parts.push_back(entry["stage_us"][stage]["min"]);
  }
  const Json& total = entry["stage_us"]["total"];
  bar.value = Microseconds(total["min"]) + " (" + Microseconds(total["median"]) + ")";
  return bar;
}

/// One scene at one size: for each setup a bar warm and a bar cold.
std::string StagePlot(const Json& section, const std::string& size, const std::string& scene) {
  std::vector<Bar> bars;
  for (const Json& warm : section) {
    if (warm["size"] != size || warm["scene"] != scene || warm["memory"] != "warm") continue;
    for (const Json& entry : section) {
      const bool same_setup = entry["kind"] == warm["kind"] && entry["threads"] == warm["threads"];
      if (same_setup && entry["size"] == size && entry["scene"] == scene) {
        bars.push_back(StageBar(entry));
      }
    }
  }
  return Card(SceneTitle(scene), StackedBars({"minimum of each stage, us"}, StageNames(), bars));
}

std::string StageTable(const Json& section, const std::string& size) {
  std::vector<Strings> rows;
  for (const Json& entry : section) {
    if (entry["size"] != size) continue;
    const bool all = entry["markers"] == entry["expected"];
    const std::string found = Text(entry["markers"]) + " of " + Text(entry["expected"]);
    Strings row{Escape(SceneTitle(entry["scene"]) + ", " + Text(entry["kind"]) + Threads(entry) +
                       ", " + Text(entry["memory"])),
                all ? found : "<span class='bad'>" + found + "</span>", Text(entry["frames"])};
    for (const Stage& stage : kStages) {
      row.push_back(ShortNumber(entry["stage_us"][stage.name]["min"]));
    }
    row.push_back(ShortNumber(entry["stage_us"]["total"]["median"]));
    row.push_back(ShortNumber(entry["stage_us"]["total"]["p99"]));
    row.push_back(ShortNumber(entry["bytes_per_second"].get<double>() / 1e9));
    rows.push_back(std::move(row));
  }
  Strings head{"minimum, us", "markers", "frames"};
  for (const Stage& stage : kStages) head.push_back(stage.name);
  for (const char* name : {"median", "p99", "GB/s"}) head.push_back(name);
  return Table(head, rows);
}

std::string StageSection(const Json& section) {
  std::string out =
      "<h2>Stages</h2><p>Whole detections with poses. Warm: the same frame again and again; cold: "
      "each frame comes from memory. \"x2\": two threads. Bars are made of the minima of the "
      "stages; beside them the minimum and (median) of the whole. GB/s is the frame's bytes over "
      "the minimum of the whole.</p>" +
      Legend(StageNames());
  const Strings sizes = Distinct(section, "size");
  for (const std::string& size : sizes) {
    std::string cards;
    for (const std::string& scene : Distinct(section, "scene")) {
      cards += StagePlot(section, size, scene);
    }
    const bool open = size == "1280x960" || sizes.size() == 1;
    out += Details(size, Grid(cards) + Details("Table", StageTable(section, size)), open);
  }
  return out;
}

std::string SystemName(const Json& system) {
  return Text(system["kind"]) + (system["ours"].get<bool>() ? Threads(system) : "");
}

/// Time of every system against a quantity of the section's entries.
std::vector<Line> Lines(const Json& section, const char* quantity, double x_unit, bool peers) {
  std::vector<Line> lines;
  for (const Json& entry : section) {
    for (const Json& system : entry["systems"]) {
      if (!peers && !system["ours"].get<bool>()) continue;
      const std::string name = SystemName(system);
      auto line = std::find_if(lines.begin(), lines.end(),
                               [&](const Line& other) { return other.label == name; });
      if (line == lines.end()) {
        lines.push_back({name, {}, {}, !system["ours"].get<bool>()});
        line = lines.end() - 1;
      }
      line->x.push_back(entry[quantity].get<double>() / x_unit);
      line->y.push_back(system["us"]["min"].get<double>() / 1000);
    }
  }
  return lines;
}

Strings Labels(const std::vector<Line>& lines) {
  Strings labels;
  for (const Line& line : lines) labels.push_back(line.label);
  return labels;
}

std::string SystemTable(const Json& section, const char* quantity) {
  Strings head{quantity};
  std::vector<Strings> rows;
  for (const Json& entry : section) {
    Strings row{Text(entry[quantity])};
    for (const Json& system : entry["systems"]) {
      if (rows.empty()) head.push_back(Escape(SystemName(system)) + ", ms");
      std::string cell = ShortNumber(system["us"]["min"].get<double>() / 1000);
      if (system["found"] != system["expected"] || system["wrong"] != 0) {
        cell += " <span class='bad'>(" + Text(system["found"]) + " found, " +
                Text(system["wrong"]) + " wrong)</span>";
      }
      row.push_back(cell);
    }
    rows.push_back(row);
  }
  return Table(head, rows);
}

std::string ScalingSection(const Json& profile) {
  const auto all = Lines(profile["pixels"], "pixels", 1e6, true);
  const auto our_pixels = Lines(profile["pixels"], "pixels", 1e6, false);
  const auto crowd = Lines(profile["markers"], "markers", 1, true);
  const auto our_crowd = Lines(profile["markers"], "markers", 1, false);
  const Axis pixels{"pixels, millions", true}, linear_pixels{"pixels, millions"};
  const Axis markers{"markers"}, time{"minimum, ms"}, log_time{"minimum, ms", true};
  return "<h2>Cost against work</h2><p>20 markers on a wall at every size; 0 to 200 markers at "
         "1280x960, 0.8 m away. Minimum of whole detections; peers (dashed) on one thread and "
         "without poses.</p>" +
         Legend(Labels(all)) +
         Grid(Card("Time against pixels", LinePlot(pixels, log_time, all)) +
              Card("Time against pixels, ours", LinePlot(linear_pixels, time, our_pixels)) +
              Card("Time against markers", LinePlot(markers, log_time, crowd)) +
              Card("Time against markers, ours", LinePlot(markers, time, our_crowd))) +
         Details("Table", SystemTable(profile["pixels"], "size") + "<br>" +
                              SystemTable(profile["markers"], "markers"));
}

/// The fastest of ours.
const Json& Fastest(const Json& systems) {
  const Json* best = nullptr;
  for (const Json& system : systems) {
    if (!system["ours"].get<bool>()) continue;
    if (best == nullptr || system["us"]["min"] < (*best)["us"]["min"]) best = &system;
  }
  return *best;
}

std::string RatioPlot(const Json& section, const std::string& size, int threads) {
  Strings series;
  std::vector<BarGroup> groups;
  for (const Json& entry : section) {
    if (entry["size"] != size || entry["threads"] != threads) continue;
    BarGroup group{SceneTitle(entry["scene"]), {}};
    const double ours = Fastest(entry["systems"])["us"]["min"];
    for (const Json& system : entry["systems"]) {
      if (system["ours"].get<bool>()) continue;
      if (groups.empty()) series.push_back(Text(system["name"]));
      group.values.push_back(system["us"]["min"].get<double>() / ours);
    }
    groups.push_back(std::move(group));
  }
  const std::string title = size + (threads == 1 ? ", 1 thread" : ", 2 threads");
  return Card(title, GroupedBars({"peer's minimum / ours", true}, series, groups));
}

std::string PeerTable(const Json& section) {
  std::vector<Strings> rows;
  for (const Json& entry : section) {
    const Json& ours = Fastest(entry["systems"])["us"];
    for (const Json& system : entry["systems"]) {
      const Json& us = system["us"];
      const bool right = system["found"] == system["expected"] && system["wrong"] == 0;
      const std::string found =
          Text(system["found"]) + " of " + Text(system["expected"]) +
          (system["wrong"] == 0 ? "" : ", " + Text(system["wrong"]) + " wrong");
      rows.push_back({Escape(Text(entry["size"]) + ", " + SceneTitle(entry["scene"]) + ", " +
                             Text(entry["threads"]) + " thr., " + Text(system["name"])),
                      right ? found : "<span class='bad'>" + found + "</span>",
                      Text(system["frames"]), ShortNumber(us["min"]), ShortNumber(us["median"]),
                      ShortNumber(us["p99"]),
                      ShortNumber(us["min"].get<double>() / ours["min"].get<double>()),
                      ShortNumber(us["median"].get<double>() / ours["median"].get<double>())});
    }
  }
  return Table(
      {"system", "markers", "frames", "min, us", "median", "p99", "min / ours", "median / ours"},
      rows);
}

/// Ours in each scene of one size, and how many times as long the others take.
std::string RatioTable(const Json& section, const std::string& size) {
  Strings head{size, "ours", "min, us", "median"};
  std::vector<Strings> rows;
  for (const Json& entry : section) {
    if (entry["size"] != size) continue;
    const Json& ours = Fastest(entry["systems"]);
    const double min = ours["us"]["min"], median = ours["us"]["median"];
    Strings row{Escape(SceneTitle(entry["scene"])) + ", " + Text(entry["threads"]) + " thr.",
                Escape(Text(ours["name"])), ShortNumber(min), ShortNumber(median)};
    for (const Json& system : entry["systems"]) {
      if (system["ours"].get<bool>()) continue;
      if (rows.empty()) head.push_back(Escape(Text(system["name"])) + " / ours");
      row.push_back(ShortNumber(system["us"]["min"].get<double>() / min) + " (" +
                    ShortNumber(system["us"]["median"].get<double>() / median) + ")");
    }
    rows.push_back(std::move(row));
  }
  return Table(head, rows);
}

std::string PeerSection(const Json& section) {
  Strings series;
  for (const Json& entry : section) {
    for (const Json& system : entry["systems"]) {
      const std::string name = Text(system["name"]);
      if (system["ours"].get<bool>()) continue;
      if (std::find(series.begin(), series.end(), name) == series.end()) series.push_back(name);
    }
  }
  std::string out =
      "<h2>Beside other systems</h2><p>Each with its own markers in the same poses and of the same "
      "size on the same backgrounds, in one process and in turn, with as many threads. Ours, with "
      "poses, is the fastest backend of each scene; the others detect only. Above 1 we are "
      "faster.</p>";
  if (series.empty()) return out + "<p class='bad'>No other system in this build.</p>";
  out += Legend(series);
  std::string cards;
  for (const std::string& size : Distinct(section, "size")) {
    for (const int threads : {1, 2}) cards += RatioPlot(section, size, threads);
  }
  std::string ratios;
  for (const std::string& size : Distinct(section, "size")) {
    ratios += RatioTable(section, size) + "<br>";
  }
  return out + Grid(cards) + Details("Ratios of the minima (of the medians)", ratios) +
         Details("Every system", PeerTable(section));
}

std::string ThroughputSection(const Json& section) {
  std::vector<Strings> rows;
  for (const Json& entry : section) {
    const double one = entry["one_fps"], two = entry["two_fps"];
    rows.push_back({Escape(Text(entry["size"]) + ", " + SceneTitle(entry["scene"]) + ", " +
                           Text(entry["backend"])),
                    ShortNumber(one), ShortNumber(two), ShortNumber(two / (2 * one))});
  }
  return "<h2>Throughput</h2><p>Frames a second of one detector on one thread, and of two on two "
         "threads; the last column is the second over twice the first.</p>" +
         Table({"frames a second", "one", "two", "two / 2 x one"}, rows);
}

std::string OpenClSection(const Json& section) {
  if (section.empty()) return "";
  std::vector<Strings> rows;
  for (const Json& entry : section) {
    rows.push_back({Text(entry["cache"]), ShortNumber(entry["construct_us"].get<double>() / 1000),
                    ShortNumber(entry["first_frame_us"].get<double>() / 1000)});
  }
  return "<h2>Start of opencl</h2><p>In a new process, with empty and with filled caches of "
         "compiled kernels.</p>" +
         Table({"caches", "construction, ms", "first frame of 1280x960, ms"}, rows);
}

}  // namespace

std::string MakePage(const Json& profile) {
  return Document("TopoTag profile", MachineSection(profile) + StageSection(profile["stages"]) +
                                         PeerSection(profile["peers"]) + ScalingSection(profile) +
                                         ThroughputSection(profile["throughput"]) +
                                         OpenClSection(profile["opencl_start"]));
}

}  // namespace topotag::bench
