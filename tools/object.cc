#include <unistd.h>

#include <CLI/CLI.hpp>
#include <climits>
#include <cmath>
#include <cstdio>
#include <memory>

#include "tools/command.h"
#include "tools/frame_source.h"
#include "tools/image_input.h"
#include "tools/object_finder.h"
#include "tools/output.h"
#include "tools/progress.h"
#include "topotag/camera_file.h"
#include "topotag/object_calibration.h"

namespace topotag::tools {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

/// The command lines as they were typed.
struct Arguments {
  std::string family = "4x4";
  std::string first_id = "0";
  std::string tag_size;
  std::string rows;
  std::string columns;
  std::string pitch;
  std::string edge;
  std::vector<std::string> inputs;
  std::string camera;
  std::string object;
  std::string ids;
  std::string pose = "photometric";
  std::string max_pixels;
  std::string output;
};

int ParseCount(const std::string& option, const std::string& text) {
  const uint64_t count = ParseUnsigned(option, text);
  if (count > INT_MAX) throw UsageError(option + ": " + text + " is too large");
  return static_cast<int>(count);
}

Family ParseFamily(const Arguments& a) {
  return ForOption("--family", [&] { return Family::Parse(a.family); });
}

/// What the options ask for cannot be made: wrong usage.
template <typename Make>
Object MakeObject(Make make) {
  try {
    return make();
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

void Write(const Object& object, const std::string& path) {
  ForFile(path, [&] { WriteObject(object, path); });
}

int RunGrid(const Arguments& a) {
  const Family family = ParseFamily(a);
  const uint64_t first_id = ParseId("--first-id", a.first_id, family);
  const int rows = ParseCount("--rows", a.rows), columns = ParseCount("--columns", a.columns);
  const double tag_size = ParsePositive("--tag-size", a.tag_size);
  const double pitch = ParsePositive("--pitch", a.pitch);
  Write(MakeObject([&] { return MakeGrid(family, first_id, rows, columns, tag_size, pitch); }),
        a.output);
  return kSuccess;
}

int RunBody(const Arguments& a) {
  const Family family = ParseFamily(a);
  const uint64_t first_id = ParseId("--first-id", a.first_id, family);
  const double tag_size = ParsePositive("--tag-size", a.tag_size);
  const double edge = ParsePositive("--edge", a.edge);
  Write(MakeObject([&] { return MakeRhombicuboctahedron(family, first_id, tag_size, edge); }),
        a.output);
  return kSuccess;
}

/// The markers to be calibrated, and what their poses are to say.
Object ParseStart(const Arguments& a) {
  if (!a.object.empty()) {
    if (!a.ids.empty()) throw UsageError("--ids: does not go with --object");
    if (!a.tag_size.empty()) throw UsageError("--tag-size: does not go with --object");
    return ForOption("--object", [&] { return ReadObject(a.object); });
  }
  if (a.ids.empty()) throw UsageError("--ids: is missing (or give --object)");
  if (a.tag_size.empty()) throw UsageError("--tag-size: is missing (or give --object)");
  Object start;
  ObjectMarker marker;
  marker.family = ParseFamily(a);
  marker.tag_size = ParsePositive("--tag-size", a.tag_size);
  for (const uint64_t id : ParseIds("--ids", a.ids, marker.family)) {
    marker.id = id;
    start.markers.push_back(marker);
  }
  ForOption("--ids", [&] {
    ValidateObject(start);
    return 0;
  });
  return start;
}

Options ParseOptions(const Arguments& a, const Object& start) {
  Options options;
  options.camera = ForOption("--camera", [&] { return ReadCamera(a.camera); });
  options.pose = ForOption("--pose", [&] { return ParsePoseMode(a.pose); });
  options.families.clear();
  SetObjectOptions(start, &options);
  return options;
}

/// The detections of all frames; those that cannot be read are named. @return the exit status
int Detect(const Arguments& a, const Options& options, std::vector<ObjectView>* views) {
  Detector detector(options);
  FrameSource source(a.inputs, ParseMaxPixels(a.max_pixels));
  std::vector<std::string> files = source.Files();
  files.push_back(a.camera);
  files.push_back(a.object);
  CheckOutputs({{"-o", a.output}}, files);
  const bool show_progress = isatty(STDERR_FILENO) != 0;
  Progress progress(show_progress, show_progress ? source.CountFrames() : 1);
  int status = kSuccess;
  for (Frame frame;;) {
    try {
      if (!source.Next(&frame)) return status;
      source.CheckSize(frame, *options.camera, a.camera);
      ForFile(frame.image, [&] {
        views->push_back({*options.camera, detector.detect(frame.pixels)});
      });
    } catch (const std::exception& error) {
      progress.Clear();
      Complain(Describe(error));
      status = kFailure;
    }
    progress.Step();
  }
}

/// Standard deviation along all three axes, of the rotation (0) or of the position (3).
double Sigma(const Matrix6& covariance, size_t first) {
  double variance = 0;
  for (size_t i = first; i < first + 3; ++i) variance += covariance[i][i];
  return std::sqrt(variance);
}

std::string Summary(const ObjectCalibration& result, size_t views) {
  char line[160];
  std::snprintf(line, sizeof line, "%zu markers, %d of %zu views, rms %.3f px, %d rejected\n",
                result.object.markers.size(), result.views, views, result.rms_px, result.rejected);
  std::string text = line;
  for (size_t i = 0; i < result.object.markers.size(); ++i) {
    const ObjectMarker& marker = result.object.markers[i];
    std::snprintf(line, sizeof line, "  %s %-8s %3d views  sigma %.4f mm  %.4f deg\n",
                  marker.family.name().c_str(), std::to_string(marker.id).c_str(),
                  result.sightings[i], Sigma(result.covariance[i], 3) * 1e3,
                  Sigma(result.covariance[i], 0) * kDegrees);
    text += line;
  }
  return text;
}

int RunCalibrate(const Arguments& a) {
  const Object start = ParseStart(a);
  std::vector<ObjectView> views;
  const int status = Detect(a, ParseOptions(a, start), &views);
  if (views.empty()) throw Error(ErrorCode::kFile, "object calibrate: no picture could be used");
  const ObjectCalibration result = CalibrateObject(
      start, views, a.object.empty() ? ObjectFrame::kFirstMarker : ObjectFrame::kAllMarkers);
  Write(result.object, a.output);
  WriteOutput("", Summary(result, views.size()));
  return status;
}

void AddMarkers(CLI::App* command, Arguments* a) {
  AddText(command, "Markers", "--family", &a->family, "NAME", "Family: 3x3 .. 8x8 (default: 4x4)");
  AddText(command, "Markers", "--first-id", &a->first_id, "N", "The first ID (default: 0)");
  AddText(command, "Markers", "--tag-size", &a->tag_size, "METRES", "Side of the white area")
      ->required();
}

void AddOutput(CLI::App* command, Arguments* a) {
  AddText(command, "Output", "-o,--output", &a->output, "FILE", "The object, as text")->required();
}

void AddGrid(CLI::App* command, Arguments* a) {
  AddMarkers(command, a);
  AddText(command, "Board", "--rows", &a->rows, "N", "Rows of markers")->required();
  AddText(command, "Board", "--columns", &a->columns, "N", "Markers in a row")->required();
  AddText(command, "Board", "--pitch", &a->pitch, "METRES", "From centre to centre")->required();
  AddOutput(command, a);
  command->footer(
      "IDs grow along the rows. The origin is the board's centre: x right, y down.\n"
      "Example:\n"
      "  topotag object grid --rows 5 --columns 7 --tag-size 0.03 --pitch 0.04 \\\n"
      "      -o board.txt");
}

void AddBody(CLI::App* command, Arguments* a) {
  AddMarkers(command, a);
  AddText(command, "Body", "--edge", &a->edge, "METRES", "Edge of the body")->required();
  AddOutput(command, a);
  command->footer(
      "IDs in order: the belt of 8 faces about the y axis, the first one looking along\n"
      "-z, the third along +x; 4 faces between belt and top (-y), 4 between belt and\n"
      "bottom; top; bottom. The origin is the centre.\n"
      "Example:\n"
      "  topotag object rhombicuboctahedron --tag-size 0.03 --edge 0.04 -o body.txt");
}

void AddCalibrate(CLI::App* command, Arguments* a) {
  AddInputs(command, "INPUT", &a->inputs, "Images, folders of images, videos");
  AddText(command, "Markers", "--object", &a->object, "FILE",
          "The object as it is meant to be; its frame is kept");
  AddText(command, "Markers", "--family", &a->family, "NAME",
          "Without --object: 3x3 .. 8x8 (default: 4x4)");
  AddText(command, "Markers", "--ids", &a->ids, "LIST",
          "Without --object: 0-17 or 1,5,7-9; the first one's frame becomes the object's");
  AddText(command, "Markers", "--tag-size", &a->tag_size, "METRES",
          "Without --object: side of the white area");
  AddText(command, "Pictures", "--camera", &a->camera, "FILE",
          "Calibration: OpenCV YAML or JSON, ROS YAML")
      ->required();
  AddText(command, "Pictures", "--pose", &a->pose, "MODE",
          "photometric (default), or vertices, which is faster and less exact");
  AddMaxPixels(command, "Pictures", &a->max_pixels);
  AddOutput(command, a);
  command->footer(
      "Take 20 to 40 sharp pictures from all sides, each with several markers in view.\n"
      "Prints how well each marker is known. Sizes are taken as given: they set the\n"
      "scale.\n"
      "Example:\n"
      "  topotag object calibrate --ids 0-17 --tag-size 0.03 --camera cam.yaml \\\n"
      "      -o body.txt photos/");
}

}  // namespace

Command AddObject(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("object", "Make or calibrate a board or a body of many markers");
  command->require_subcommand(0, 1);
  const auto arguments = std::make_shared<Arguments>();
  AddGrid(command->add_subcommand("grid", "A flat board"), arguments.get());
  AddBody(command->add_subcommand("rhombicuboctahedron", "A body with 18 square faces"),
          arguments.get());
  AddCalibrate(command->add_subcommand("calibrate", "Measure where the markers are, from pictures"),
               arguments.get());
  command->footer(
      "topotag object COMMAND --help explains a command.\n"
      "An object file has a line for each marker: FAMILY ID SIZE TX TY TZ RX RY RZ, in\n"
      "metres and radians (axis times angle); x_object = R x_tag + t. # begins a\n"
      "comment.");
  return [arguments, command]() -> int {
    if (command->got_subcommand("grid")) return RunGrid(*arguments);
    if (command->got_subcommand("rhombicuboctahedron")) return RunBody(*arguments);
    if (command->got_subcommand("calibrate")) return RunCalibrate(*arguments);
    throw UsageError(
        "a command is missing: grid, rhombicuboctahedron or calibrate; see topotag object --help");
  };
}

}  // namespace topotag::tools
