#include "tools/detect_arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <climits>

#include "tools/image_input.h"
#include "tools/tag_sizes.h"
#include "topotag/camera_file.h"

namespace topotag::tools {
namespace {

Rect ParseRoi(const std::string& text) {
  const std::vector<double> values = ParseNumbers("--roi", text, 4);
  for (const double value : values) {
    if (value < 0 || value > kMaxImageSide || value != static_cast<int>(value)) {
      throw UsageError("--roi: '" + text + "' is not X,Y,WIDTH,HEIGHT in whole pixels");
    }
  }
  if (values[2] < 1 || values[3] < 1) throw UsageError("--roi: '" + text + "' is empty");
  return {static_cast<int>(values[0]), static_cast<int>(values[1]), static_cast<int>(values[2]),
          static_cast<int>(values[3])};
}

int ParseThreads(const std::string& text) {
  const uint64_t threads = ParseUnsigned("--threads", text);
  if (threads < 1 || threads > kMaxThreads) {
    throw UsageError("--threads: " + text + " is not a number of threads, 1 to " +
                     std::to_string(kMaxThreads));
  }
  return static_cast<int>(threads);
}

int ParseDevice(const std::string& text) {
  const uint64_t index = ParseUnsigned("--device", text);
  if (index > INT_MAX) throw UsageError("--device: there is no device " + text);
  return static_cast<int>(index);
}

/// Adds the IDs of "4x4:0-99,278" to those in use.
void AddIds(const std::string& text, Options* options) {
  const size_t colon = text.find(':');
  if (colon == std::string::npos) {
    throw UsageError("--ids: '" + text + "' is not FAMILY:LIST, as in 4x4:0-99,278");
  }
  const Family family = ForOption("--ids", [&] { return Family::Parse(text.substr(0, colon)); });
  if (std::find(options->families.begin(), options->families.end(), family) ==
      options->families.end()) {
    throw UsageError("--ids: family " + family.name() + " is not looked for; see --family");
  }
  const std::vector<uint64_t> ids = ParseIds("--ids", text.substr(colon + 1), family);
  std::vector<uint64_t>& all = options->ids[family.n()];
  all.insert(all.end(), ids.begin(), ids.end());
}

int ParseHiddenNodes(const std::string& text) {
  const uint64_t nodes = ParseUnsigned("--hidden-nodes", text);
  if (nodes > kMaxVertices) {
    throw UsageError("--hidden-nodes: " + text + " is not a number of nodes, 0 to " +
                     std::to_string(kMaxVertices));
  }
  return static_cast<int>(nodes);
}

}  // namespace

Options ParseOptions(const DetectArguments& arguments) {
  Options options;
  options.families = ForOption("--family", [&] { return Family::ParseList(arguments.family); });
  options.preset = ForOption("--preset", [&] { return ParsePreset(arguments.preset); });
  CheckChoice("--far", arguments.far, {"on", "off"});
  CheckChoice("--quality", arguments.quality, {"on", "off"});
  CheckChoice("--track", arguments.track, {"on", "off"});
  options.far = arguments.far == "on";
  for (const std::string& ids : arguments.ids) AddIds(ids, &options);
  options.hidden_nodes = ParseHiddenNodes(arguments.hidden_nodes);
  options.pre_blur = arguments.pre_blur;
  options.inverted = arguments.inverted;
  options.min_size = ParseNotNegative("--min-size", arguments.min_size);
  options.backend = ForOption("--backend", [&] { return ParseBackend(arguments.backend); });
  options.threads = ParseThreads(arguments.threads);
  options.pose = ForOption("--pose", [&] { return ParsePoseMode(arguments.pose); });
  if (!arguments.device.empty()) options.device = ParseDevice(arguments.device);
  if (!arguments.camera.empty()) {
    options.camera = ForOption("--camera", [&] { return ReadCamera(arguments.camera); });
  }
  for (const std::string& sizes : arguments.tag_sizes) AddTagSizes(sizes, &options);
  if (!arguments.roi.empty()) options.roi = ParseRoi(arguments.roi);
  return options;
}

void AddDetectArguments(CLI::App* command, DetectArguments* arguments) {
  DetectArguments& a = *arguments;
  AddInputs(command, "INPUT", &a.inputs, "Images, folders of images, videos, camera:INDEX");
  AddText(command, "What to find", "--family", &a.family, "LIST",
          "From 3x3 to 8x8 (default: 3x3,4x4,5x5)");
  AddText(command, "What to find", "--roi", &a.roi, "X,Y,W,H",
          "Search this part only, in pixels (default: all)");
  AddText(command, "What to find", "--preset", &a.preset, "NAME",
          "default, or paper for the paper's parameters");
  AddText(command, "What to find", "--far", &a.far, "ON",
          "on: also markers whose holes are not resolved");
  command->add_option("--ids", a.ids, "IDs in use, others are left out: 4x4:0-99,278")
      ->type_name("FAMILY:LIST")
      ->allow_extra_args(false)
      ->group("What to find");
  AddText(command, "What to find", "--hidden-nodes", &a.hidden_nodes, "N",
          "Also markers with up to N hidden nodes (default: 0)");
  command->add_flag("--inverted", a.inverted, "Also markers with white and black exchanged")
      ->group("What to find");
  AddText(command, "What to find", "--min-size", &a.min_size, "PX",
          "Only markers with white sides of PX pixels or more");
  command->add_flag("--pre-blur", a.pre_blur, "Smooth each frame first, against severe noise")
      ->group("What to find");
  AddText(command, "What to find", "--track", &a.track, "ON",
          "on: follow markers from frame to frame, faster");
  AddText(command, "Pose", "--camera", &a.camera, "FILE",
          "Calibration: OpenCV YAML or JSON, ROS YAML");
  command->add_option("--tag-size", a.tag_sizes, "White side, for poses: 0.05,3x3=0.03,4x4:0-9=0.1")
      ->type_name("METRES")
      ->allow_extra_args(false)
      ->group("Pose");
  command->add_option("--object", a.objects, "A board or body of markers; see topotag object")
      ->type_name("FILE")
      ->allow_extra_args(false)
      ->group("Pose");
  AddText(command, "Pose", "--pose", &a.pose, "MODE",
          "vertices (default), or photometric: slower, more exact");
  AddText(command, "Output", "--format", &a.format, "NAME",
          "text (default), json (a line a frame) or csv");
  AddText(command, "Output", "--quality", &a.quality, "ON",
          "on: how well each marker is seen, too");
  AddText(command, "Output", "--output", &a.output, "FILE",
          "Results, once complete (default: standard output)");
  AddText(command, "Output", "--draw", &a.draw, "DIR",
          "Write each frame with what was found (PNG)");
  AddText(command, "Output", "--stages", &a.stages, "DIR",
          "Write a picture of each stage of each frame (PNG)");
  AddText(command, "Computation", "--backend", &a.backend, "NAME",
          "scalar, simd, opencl, or auto (default): that of TOPOTAG_BACKEND, else the fastest; "
          "see topotag info");
  AddText(command, "Computation", "--threads", &a.threads, "N",
          "Threads for each frame (default: at most 2)");
  AddText(command, "Computation", "--device", &a.device, "INDEX",
          "OpenCL device, see topotag info (default: a GPU)");
  AddMaxPixels(command, "Computation", &a.max_pixels);
}

}  // namespace topotag::tools
