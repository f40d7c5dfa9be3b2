#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <climits>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>

#include "tools/command.h"
#include "tools/draw.h"
#include "tools/frame_source.h"
#include "tools/image_input.h"
#include "tools/object_finder.h"
#include "tools/output.h"
#include "tools/progress.h"
#include "tools/report.h"
#include "tools/stage_pictures.h"
#include "tools/tag_sizes.h"
#include "topotag/camera_file.h"
#include "topotag/detector.h"
#include "topotag/tracker.h"

namespace topotag::tools {
namespace {

/// The command line as it was typed.
struct Arguments {
  std::vector<std::string> inputs;
  std::string family = "3x3,4x4,5x5";
  std::string camera;
  std::vector<std::string> tag_sizes;
  std::vector<std::string> objects;
  std::string roi;
  std::string backend = "auto";
  std::string threads = std::to_string(DefaultThreads());
  std::string device;
  std::string max_pixels;
  std::string preset = "default";
  std::string far = "off";
  std::vector<std::string> ids;
  std::string hidden_nodes = "0";
  bool pre_blur = false;
  bool inverted = false;
  std::string min_size = "0";
  std::string quality = "off";
  std::string track = "off";
  std::string pose = "vertices";
  std::string format = "text";
  std::string output;
  std::string draw;
  std::string stages;
};

volatile sig_atomic_t g_interrupted = 0;  // the signal

void Interrupt(int signal) { g_interrupted = signal; }

/// The frame in work is finished; a second signal ends the process at once.
void CatchInterrupts() {
  struct sigaction action {};
  action.sa_handler = Interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

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

Options ParseOptions(const Arguments& arguments) {
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

Format ParseFormat(const std::string& name) {
  CheckChoice("--format", name, {"text", "json", "csv"});
  return name == "text" ? Format::kText : name == "json" ? Format::kJson : Format::kCsv;
}

/// A backend that this build or machine lacks is wrong usage, whoever asked for it. So is a device
/// for a backend that has none; which one `auto` means, the detector knows.
Detector MakeDetector(const Arguments& arguments, const Options& options) {
  try {
    Detector detector(options);
    if (options.device && detector.backend().rfind(Name(BackendKind::kOpenCl), 0) != 0) {
      throw UsageError("--device: only with --backend opencl or TOPOTAG_BACKEND=opencl");
    }
    return detector;
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kUnavailable) {
      const char* wanted = std::getenv("TOPOTAG_BACKEND");
      const bool by_environment = options.backend == BackendKind::kAuto && wanted != nullptr;
      throw UsageError(Named(by_environment ? std::string("TOPOTAG_BACKEND=") + wanted
                                            : "--backend " + arguments.backend,
                             error.what()));
    }
    if (error.code() == ErrorCode::kInvalidArgument) throw UsageError(error.what());
    throw;
  }
}

/// One run over all inputs.
class Run {
 public:
  Run(const Arguments& arguments, const Options& options, ObjectFinder* objects, Format format)
      : arguments_(arguments),
        options_(options),
        objects_(*objects),
        format_(format),
        columns_{arguments.inverted, arguments.quality == "on", arguments.track == "on"},
        detector_(MakeDetector(arguments, options)),
        source_(arguments.inputs, ParseMaxPixels(arguments.max_pixels)),
        output_(arguments.output) {
    const std::vector<std::string> files = source_.Files();
    ProtectInputs(files);
    if (!arguments.draw.empty()) draw_.emplace(arguments.draw, files);
    if (!arguments.stages.empty()) stages_.emplace(arguments.stages, files);
    if (columns_.track) tracker_.emplace(TrackerOptions{options});
  }

  int Execute();

 private:
  /// @return false at the end.
  bool DetectNext();
  void ProtectInputs(const std::vector<std::string>& files) const;
  void CheckSize(const Frame& frame) const;
  void Search();
  void WritePictures();

  const Arguments& arguments_;
  const Options& options_;
  ObjectFinder& objects_;
  const Format format_;
  const ExtraColumns columns_;
  Detector detector_;
  std::optional<Tracker> tracker_;
  size_t tracked_input_ = 0;
  FrameSource source_;
  OutputStream output_;
  std::optional<PictureFolder> draw_;
  std::optional<PictureFolder> stages_;
  Frame frame_;
  FrameResult result_;
};

void Run::ProtectInputs(const std::vector<std::string>& files) const {
  for (const std::string& file : files) {
    std::error_code ignored;
    if (!output_.is_stdout() && std::filesystem::equivalent(arguments_.output, file, ignored)) {
      throw UsageError("--output: " + arguments_.output + " is an input");
    }
  }
}

void Run::CheckSize(const Frame& frame) const {
  if (!options_.camera || options_.camera->width == 0) return;
  const Camera& camera = *options_.camera;
  if (frame.pixels.width == camera.width && frame.pixels.height == camera.height) return;
  throw Error(ErrorCode::kInvalidArgument,
              "the image is " + std::to_string(frame.pixels.width) + "x" +
                  std::to_string(frame.pixels.height) + ", the camera file " + arguments_.camera +
                  " is for " + std::to_string(camera.width) + "x" + std::to_string(camera.height));
}

void Run::Search() {
  if (!tracker_) {
    detector_.detect(frame_.pixels, &result_.detections);
    result_.backend = detector_.backend();
    result_.times = detector_.times();
    return;
  }
  if (frame_.input != tracked_input_) tracker_->reset();
  tracked_input_ = frame_.input;
  tracker_->track(frame_.pixels, &result_.detections);
  result_.tracks = tracker_->states();
  result_.backend = tracker_->backend();
  result_.times = tracker_->times();
}

bool Run::DetectNext() {
  if (!source_.Next(&frame_)) return false;
  try {
    CheckSize(frame_);
    Search();
  } catch (const std::exception& error) {
    const std::string frame =
        frame_.is_sequence ? "frame " + std::to_string(frame_.index) + ": " : std::string();
    throw Error(ErrorCode::kFile, Named(frame_.image, frame + Describe(error)));
  }
  if (!objects_.empty()) objects_.Find(result_.detections, &result_.objects.emplace());
  result_.image = frame_.image;
  result_.frame = frame_.index;
  result_.is_sequence = frame_.is_sequence;
  result_.width = frame_.pixels.width;
  result_.height = frame_.pixels.height;
  return true;
}

void Run::WritePictures() {
  if (!draw_ && !stages_) return;
  try {
    cv::Mat picture = DrawDetections(frame_.pixels, result_.detections, options_);
    if (result_.objects) objects_.Draw(*result_.objects, *options_.camera, &picture);
    if (draw_) draw_->Write(frame_.stem, {{"", picture}});
    if (stages_) stages_->Write(frame_.stem, StagePictures(detector_, frame_.pixels, picture));
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kFile, Named(frame_.image, "its picture: " + Describe(error)));
  }
}

int Run::Execute() {
  const bool show_progress = isatty(STDERR_FILENO) != 0;
  Progress progress(show_progress, show_progress ? source_.CountFrames() : 1);
  const bool shared_terminal = output_.is_stdout() && isatty(STDOUT_FILENO) != 0;
  int status = kSuccess;
  output_.Write(FormatHeader(format_, columns_));
  CatchInterrupts();
  while (g_interrupted == 0) {
    try {
      if (!DetectNext()) break;
    } catch (const std::exception& error) {
      progress.Clear();
      Complain(Describe(error));
      progress.Step();
      status = kFailure;
      continue;
    }
    WritePictures();
    if (shared_terminal) progress.Clear();
    output_.Write(FormatFrame(format_, columns_, result_));
    progress.Step();
  }
  if (g_interrupted != 0 && !source_.at_camera()) {
    progress.Clear();
    Complain(frame_.image.empty() ? "interrupted" : "interrupted after " + frame_.image);
    return kSignal + g_interrupted;
  }
  output_.Finish();
  return status;
}

ObjectFinder ReadObjects(const Arguments& arguments, bool choose_families, Options* options) {
  ObjectFinder objects(arguments.objects);
  if (objects.empty()) return objects;
  if (!options->camera) throw UsageError("--object: needs --camera");
  objects.SetOptions(choose_families, options);
  objects.SetCamera(*options->camera);
  return objects;
}

int RunDetect(const Arguments& arguments) {
  Options options = ParseOptions(arguments);
  ObjectFinder objects = ReadObjects(arguments, arguments.family == Arguments().family, &options);
  const Format format = ParseFormat(arguments.format);
  if (arguments.track == "on" && !arguments.stages.empty()) {
    throw UsageError("--stages: not with --track on, which leaves out most of each frame");
  }
  return Run(arguments, options, &objects, format).Execute();
}

}  // namespace

Command AddDetect(CLI::App* app) {
  CLI::App* command = app->add_subcommand("detect", "Find markers in images, videos or a camera");
  const auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  command->add_option("INPUT", a.inputs, "Images, folders of images, videos, camera:INDEX")
      ->required()
      ->type_name("")
      ->check([](const std::string& input) {
        return input.empty() ? std::string("the name is empty") : std::string();
      });
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
  command->footer(
      "Pixel (0, 0) is the centre of the top-left one. Poses are in metres, in camera\n"
      "axes: x right, y down, z forward. A camera runs until Ctrl-C.\n"
      "Examples:\n"
      "  topotag detect --camera cam.yaml --tag-size 0.05 --format json photos/\n"
      "  topotag detect --camera cam.yaml --object board.txt photo.jpg\n"
      "  topotag detect --draw out video.mp4\n"
      "Exit status: 0 all inputs processed, 1 some file could not be read or written,\n"
      "2 wrong usage, 128 + N interrupted by signal N.");
  return [arguments] { return RunDetect(*arguments); };
}

}  // namespace topotag::tools
