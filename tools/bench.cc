#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench/timing.h"
#include "host/one_line.h"
#include "tools/command.h"
#include "tools/image_input.h"
#include "tools/output.h"
#include "tools/report.h"
#include "tools/tag_sizes.h"
#include "topotag/camera_file.h"
#include "topotag/detector.h"
#include "topotag/image_file.h"

namespace topotag::tools {
namespace {

using Json = nlohmann::ordered_json;

/// The command line as it was typed.
struct Arguments {
  std::vector<std::string> images;
  std::string family = "3x3,4x4,5x5";
  std::string camera;
  std::string tag_size;
  std::string frames;
  std::string max_pixels;
  std::string format = "text";
};

/// One, two, and all that the machine has.
std::vector<int> ThreadCounts() {
  std::vector<int> counts{1, 2};
  const int all = static_cast<int>(std::thread::hardware_concurrency());
  if (all > 2) counts.push_back(all);
  return counts;
}

Options ParseOptions(const Arguments& arguments) {
  Options options;
  options.families = ForOption("--family", [&] { return Family::ParseList(arguments.family); });
  if (!arguments.camera.empty()) {
    options.camera = ForOption("--camera", [&] { return ReadCamera(arguments.camera); });
  }
  if (!arguments.tag_size.empty()) AddTagSizes(arguments.tag_size, &options);
  Options checked = options;
  checked.backend = BackendKind::kScalar;
  ForOption("bench", [&] { return Detector(checked); });
  return options;
}

bench::Budget ParseBudget(const std::string& frames) {
  if (frames.empty()) return {};
  constexpr uint64_t kMaxFrames = 1000000;
  const uint64_t count = ParseUnsigned("--frames", frames);
  if (count < 1 || count > kMaxFrames) {
    throw UsageError("--frames: " + frames + " is not within 1 .. " + std::to_string(kMaxFrames));
  }
  return {0, count, count};
}

/// Folders are replaced by their images; each that cannot be read is named.
std::vector<std::string> ListInputs(const std::vector<std::string>& inputs, int* status) {
  std::vector<std::string> files;
  for (const std::string& input : inputs) {
    std::error_code ignored;
    if (!std::filesystem::is_directory(input, ignored)) {
      files.push_back(input);
      continue;
    }
    try {
      const std::vector<std::string> listed = ForFile(input, [&] { return ListImages(input); });
      files.insert(files.end(), listed.begin(), listed.end());
    } catch (const Error& error) {
      Complain(error.what());
      *status = kFailure;
    }
  }
  return files;
}

double Tenths(double value) { return std::round(value * 10) / 10; }

std::string FormatJson(const std::string& path, const Image& image,
                       const std::vector<bench::Measured>& results) {
  Json json{{"image", path}, {"width", image.width()}, {"height", image.height()}};
  json["results"] = Json::array();
  for (const bench::Measured& measured : results) {
    Json result{{"backend", measured.setup.name},
                {"threads", measured.setup.threads},
                {"frames", measured.frames}};
    for (size_t s = 0; s < bench::kStages.size(); ++s) {
      const bench::Spread& us = measured.stages[s];
      result["stage_us"][bench::kStages[s].name] = {
          {"min", Tenths(us.min)}, {"median", Tenths(us.median)}, {"p99", Tenths(us.p99)}};
    }
    json["results"].push_back(std::move(result));
  }
  return Dump(json) + "\n";
}

std::string FormatText(const std::string& path, const Image& image,
                       const std::vector<bench::Measured>& results) {
  std::string text = OneLine(path) + ": " + std::to_string(image.width()) + "x" +
                     std::to_string(image.height()) + ", times in microseconds\n";
  char line[128];
  for (const bench::Measured& measured : results) {
    const std::string setup = measured.setup.name + ", " + std::to_string(measured.setup.threads) +
                              (measured.setup.threads == 1 ? " thread, " : " threads, ") +
                              std::to_string(measured.frames) + " frames, " +
                              std::to_string(measured.markers) +
                              (measured.markers == 1 ? " marker" : " markers");
    std::snprintf(line, sizeof line, "    %-10s %10s %10s %10s\n", "", "min", "median", "p99");
    text += "  " + setup + "\n" + line;
    for (size_t s = 0; s < bench::kStages.size(); ++s) {
      const bench::Spread& us = measured.stages[s];
      std::snprintf(line, sizeof line, "    %-10s %10.1f %10.1f %10.1f\n", bench::kStages[s].name,
                    us.min, us.median, us.p99);
      text += line;
    }
  }
  return text;
}

int RunBench(const Arguments& arguments) {
  CheckChoice("--format", arguments.format, {"text", "json"});
  const bool is_text = arguments.format == "text";
  const Options options = ParseOptions(arguments);
  const bench::Budget budget = ParseBudget(arguments.frames);
  const uint64_t max_pixels = ParseMaxPixels(arguments.max_pixels);
  const bench::Setups setups = bench::FindSetups(ThreadCounts());
  int status = kSuccess;
  OutputStream output("");
  if (is_text) {
    for (const std::string& reason : setups.missing) output.Write("left out: " + reason + "\n");
  }
  for (const std::string& path : ListInputs(arguments.images, &status)) {
    std::string report;
    try {
      ForFile(path, [&] {
        const Image image = ReadInput(path, max_pixels);
        const auto results = bench::Measure(setups.available, options, {image.view()}, budget);
        report = is_text ? FormatText(path, image, results) : FormatJson(path, image, results);
      });
    } catch (const std::exception& error) {
      Complain(Named(path, Describe(error)));
      status = kFailure;
    }
    output.Write(report);
  }
  return status;
}

}  // namespace

Command AddBench(CLI::App* app) {
  CLI::App* command = app->add_subcommand("bench", "Time each stage on your own images");
  const auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  AddInputs(command, "IMAGE", &a.images, "Images, folders of images");
  AddText(command, "What to do", "--family", &a.family, "LIST",
          "From 3x3 to 8x8 (default: 3x3,4x4,5x5)");
  AddText(command, "What to do", "--camera", &a.camera, "FILE",
          "Calibration: OpenCV YAML or JSON, ROS YAML");
  AddText(command, "What to do", "--tag-size", &a.tag_size, "METRES",
          "Side of the white area; poses need this and --camera");
  AddText(command, "What to do", "--frames", &a.frames, "N",
          "Times that each image is detected (default: half a second's worth, 10 .. 2000)");
  AddMaxPixels(command, "What to do", &a.max_pixels);
  AddText(command, "Output", "--format", &a.format, "NAME",
          "text (default) or json (a line an image)");
  command->footer(
      "Every backend that is there, with one thread, two, and all that the machine has\n"
      "(scalar: one), in turn; minimum, median and 99th percentile of each stage.\n"
      "Examples:\n"
      "  topotag bench photo.jpg\n"
      "  topotag bench --camera cam.yaml --tag-size 0.05 --format json photos/\n"
      "Exit status: 0 all images processed, 1 some file could not be read, 2 wrong\n"
      "usage.");
  return [arguments] { return RunBench(*arguments); };
}

}  // namespace topotag::tools
