// Every table of the paper on rendered sequences, beside the peers in the same poses: a
// self-contained HTML page and the figures as JSON.
//   paper [--photos DIR] [--output paper.html] [--json paper.json] [--sections A,B] [--quick]

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "bench/command.h"
#include "bench/machine.h"
#include "bench/paper/context.h"
#include "bench/paper/page.h"
#include "bench/paper/systems.h"
#include "bench/peers.h"
#include "host/file.h"

namespace topotag::bench::paper {
namespace {

using Clock = std::chrono::steady_clock;

struct Arguments {
  std::string photos;
  std::string output = "paper.html";
  std::string json = "paper.json";
  std::vector<std::string> sections;
  int threads = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, 64U));
  bool quick = false;
};

/// A section with its share of the time of a run, for the progress bar.
struct Entry {
  const char* id;
  const char* title;
  Section (*measure)(const Context&);
  double cost;        ///< seconds of a full run on two processors, roughly
  double quick_cost;  ///< and of a quick one
};

constexpr Entry kEntries[] = {
    {"range", "dictionary and distance", MeasureRange, 200, 15},
    {"sequences", "sequences", MeasureSequences, 110, 12},
    {"time", "time", MeasureTime, 75, 8},
    {"false-positives", "false positives", MeasureFalsePositives, 60, 1},
    {"jitter", "jitter", MeasureJitter, 130, 10},
    {"shapes", "shapes", MeasureShapes, 80, 5},
    {"occlusion", "occlusion", MeasureOcclusion, 90, 8},
    {"noise", "noise", MeasureNoise, 100, 4},
    {"light", "light and motion", MeasureLight, 160, 8},
};

/// Those that are asked for; all of them unless some are named.
std::vector<const Entry*> Chosen(const Arguments& arguments) {
  std::vector<const Entry*> chosen;
  for (const Entry& entry : kEntries) {
    const auto& names = arguments.sections;
    if (names.empty() || std::find(names.begin(), names.end(), entry.id) != names.end()) {
      chosen.push_back(&entry);
    }
  }
  return chosen;
}

RunFacts FactsOf(const Arguments& arguments, const Photos& photos) {
  RunFacts facts;
  facts.machine = DescribeMachine();
  facts.backgrounds = photos.source;
  for (const auto& system : MakeSystems()) {
    facts.systems.push_back(system->name() + ": " + system->description());
  }
  for (const auto& system : MakeRefinedPeerSystems()) {
    facts.systems.push_back(system->name() + ": " + system->description());
  }
  facts.missing = MissingPeers();
  facts.quick = arguments.quick;
  return facts;
}

std::vector<Section> MeasureAll(const Arguments& arguments, const Photos& photos, Json* seconds) {
  const std::vector<const Entry*> chosen = Chosen(arguments);
  const auto cost = [&arguments](const Entry* entry) {
    return arguments.quick ? entry->quick_cost : entry->cost;
  };
  double total = 0;
  for (const Entry* entry : chosen) total += cost(entry);
  Progress progress(total);
  const Context context{arguments.quick, arguments.threads, arguments.photos, &photos, &progress};
  std::vector<Section> sections;
  for (const Entry* entry : chosen) {
    const Clock::time_point start = Clock::now();
    progress.Begin(entry->title, cost(entry));
    sections.push_back(entry->measure(context));
    (*seconds)[entry->id] = std::chrono::duration<double>(Clock::now() - start).count();
  }
  return sections;
}

int Run(const Arguments& arguments) {
  const Clock::time_point start = Clock::now();
  // Where they cannot be written is found out before the minutes of measuring.
  OutputFile json_file(arguments.json), page_file(arguments.output);
  const Photos photos = LoadPhotos(arguments.photos);
  RunFacts facts = FactsOf(arguments, photos);
  Json seconds = Json::object();
  const std::vector<Section> sections = MeasureAll(arguments, photos, &seconds);
  facts.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  Json figures = MakeJson(facts, sections);
  figures["section_seconds"] = seconds;
  const std::string json = figures.dump(1) + "\n", page = MakePage(facts, sections);
  json_file.Write(json.data(), json.size());
  json_file.Commit();
  page_file.Write(page.data(), page.size());
  page_file.Commit();
  std::printf("%s and %s, %.0f s\n", arguments.output.c_str(), arguments.json.c_str(),
              facts.seconds);
  int broken = 0;
  for (const Section& section : sections) {
    for (const std::string& text : section.broken) {
      ++broken;
      std::fprintf(stderr, "paper: %s: %s\n", section.id.c_str(), text.c_str());
    }
  }
  return broken == 0 ? 0 : 1;
}

int Main(int argc, char** argv) {
  Arguments arguments;
  std::vector<std::string> ids;
  std::string list;
  for (const Entry& entry : kEntries) {
    ids.emplace_back(entry.id);
    list += (list.empty() ? "" : ", ") + ids.back();
  }
  CLI::App app("The paper's tables on rendered sequences, beside its peers.", "paper");
  app.add_option("--photos", arguments.photos,
                 "Folder of photographs: backgrounds, and what false positives are counted on "
                 "(default: procedural clutter)");
  app.add_option("--output", arguments.output, "Page to write (default: paper.html)");
  app.add_option("--json", arguments.json, "Figures to write (default: paper.json)");
  app.add_option("--sections", arguments.sections,
                 "Only these, separated by commas: " + list + " (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(ids));
  app.add_option("--threads", arguments.threads,
                 "For everything but time measurements (default: one a processor)")
      ->check(CLI::Range(1, 64));
  app.add_flag("--quick", arguments.quick, "A few frames of everything");
  CLI11_PARSE(app, argc, argv);
  return Run(arguments);
}

}  // namespace
}  // namespace topotag::bench::paper

int main(int argc, char** argv) {
  return topotag::bench::RunCommand("paper", topotag::bench::paper::Main, argc, argv);
}
