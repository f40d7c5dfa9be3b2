// One command that measures everything and writes a self-contained HTML page and the JSON behind
// it:
//   profile [--photos DIR] [--output profile.html] [--json profile.json] [--quick]
//   profile --from profile.json [--output profile.html]       the page of an earlier run

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "bench/command.h"
#include "bench/machine.h"
#include "bench/page.h"
#include "bench/peers.h"
#include "bench/profile_sections.h"
#include "host/file.h"

namespace topotag::bench {
namespace {

struct Arguments {
  std::string photos;
  std::string output = "profile.html";
  std::string json = "profile.json";
  std::string from;
  bool quick = false;
  bool time_opencl_start = false;
};

Json MeasureAll(const Subject& subject, const std::string& program) {
  Json profile;
  profile["machine"] = DescribeMachine();
  profile["backends"] = Json::array();
  for (const Setup& setup : subject.setups.available) {
    if (setup.threads == 1) profile["backends"].push_back(setup.name);
  }
  profile["missing"] = subject.setups.missing;
  for (const std::string& reason : MissingPeers()) profile["missing"].push_back(reason);
  profile["peers_used"] = Json::array();
  for (const auto& peer : MakePeers({})) {
    profile["peers_used"].push_back(peer->name() + ": " + peer->description());
  }
  profile["scenes"] = {{"backgrounds", subject.photos.source},
                       {"cold_mib", subject.effort.cold_bytes >> 20}};
  profile["stages"] = MeasureStages(subject);
  profile["peers"] = MeasurePeers(subject);
  profile["pixels"] = MeasurePixels(subject);
  profile["markers"] = MeasureMarkers(subject);
  profile["throughput"] = MeasureThroughput(subject);
  profile["opencl_start"] = MeasureOpenClStart(subject, program);
  return profile;
}

/// Whether a system has missed a marker of its own, or seen one that is not there.
bool AnyMiss(const Json& profile) {
  for (const Json& entry : profile["stages"]) {
    if (entry["markers"] != entry["expected"]) return true;
  }
  for (const char* section : {"peers", "pixels", "markers"}) {
    for (const Json& entry : profile[section]) {
      for (const Json& system : entry["systems"]) {
        if (system["found"] != system["expected"] || system["wrong"] != 0) return true;
      }
    }
  }
  return false;
}

int RunFrom(const Arguments& arguments) {
  constexpr size_t kMaxBytes = 64 << 20;
  const Json profile = Json::parse(ReadText(arguments.from, kMaxBytes));
  WriteWholeFile(arguments.output, MakePage(profile));
  return 0;
}

int Run(const Arguments& arguments, const std::string& program) {
  Subject subject;
  subject.setups = FindSetups({1, 2});
  subject.photos = LoadPhotos(arguments.photos);
  subject.effort = arguments.quick ? QuickEffort() : FullEffort();
  // Where they cannot be written is found out before the minutes of measuring.
  OutputFile json_file(arguments.json), page_file(arguments.output);
  const Json profile = MeasureAll(subject, program);
  const std::string json = profile.dump(1) + "\n", page = MakePage(profile);
  json_file.Write(json.data(), json.size());
  json_file.Commit();
  page_file.Write(page.data(), page.size());
  page_file.Commit();
  std::printf("%s and %s\n", arguments.output.c_str(), arguments.json.c_str());
  if (!AnyMiss(profile)) return 0;
  std::fprintf(stderr, "profile: not every system found exactly its markers; see the page\n");
  return 1;
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Measures the detector and writes a page with plots.", "profile");
  app.add_option("--photos", arguments.photos,
                 "Folder of photographs for backgrounds (default: procedural clutter)");
  app.add_option("--output", arguments.output, "Page to write (default: profile.html)");
  app.add_option("--json", arguments.json, "Figures to write (default: profile.json)");
  app.add_option("--from", arguments.from, "Makes the page of these figures and measures nothing");
  app.add_flag("--quick", arguments.quick, "Small frames and few of them, in half a minute");
  app.add_flag("--time-opencl-start", arguments.time_opencl_start)->group("");
  CLI11_PARSE(app, argc, argv);
  if (arguments.time_opencl_start) {
    TimeOpenClStart();
    return 0;
  }
  if (!arguments.from.empty()) return RunFrom(arguments);
  return Run(arguments, argv[0]);
}

}  // namespace
}  // namespace topotag::bench

int main(int argc, char** argv) {
  return topotag::bench::RunCommand("profile", topotag::bench::Main, argc, argv);
}
