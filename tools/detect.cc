#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <memory>
#include <optional>

#include "host/check.h"
#include "tools/detect_arguments.h"
#include "tools/draw.h"
#include "tools/frame_source.h"
#include "tools/image_input.h"
#include "tools/object_finder.h"
#include "tools/output.h"
#include "tools/progress.h"
#include "tools/report.h"
#include "tools/stage_pictures.h"
#include "topotag/detector.h"
#include "topotag/tracker.h"

namespace topotag::tools {
namespace {

volatile sig_atomic_t g_interrupted = 0;  // the signal

void Interrupt(int signal) { g_interrupted = signal; }

/// The frame in work is finished; a second signal ends the process at once. A signal that the
/// caller wants to be ignored, as of a script's background jobs, is.
void CatchInterrupts() {
  struct sigaction action {};
  action.sa_handler = Interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  for (const int number : {SIGINT, SIGTERM}) {
    struct sigaction inherited {};
    sigaction(number, nullptr, &inherited);
    if (inherited.sa_handler != SIG_IGN) sigaction(number, &action, nullptr);
  }
}

Format ParseFormat(const std::string& name) {
  CheckChoice("--format", name, {"text", "json", "csv"});
  return name == "text" ? Format::kText : name == "json" ? Format::kJson : Format::kCsv;
}

/// A detector or a tracker. A backend that this build or machine lacks is wrong usage, whoever
/// asked for it. So is a device for a backend that has none; which one `auto` means, the searcher
/// knows.
template <class Searcher, class Configuration>
Searcher MakeSearcher(const DetectArguments& arguments, const Configuration& configuration) {
  try {
    Searcher searcher(configuration);
    if (!arguments.device.empty() && searcher.backend().rfind(Name(BackendKind::kOpenCl), 0) != 0) {
      throw UsageError("--device: only with --backend opencl or TOPOTAG_BACKEND=opencl");
    }
    return searcher;
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kUnavailable) {
      const char* wanted = std::getenv("TOPOTAG_BACKEND");
      const bool by_environment =
          arguments.backend == Name(BackendKind::kAuto) && wanted != nullptr;
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
  Run(const DetectArguments& arguments, const Options& options, ObjectFinder* objects,
      Format format)
      : arguments_(arguments),
        options_(options),
        objects_(*objects),
        format_(format),
        columns_{arguments.inverted, arguments.quality == "on", arguments.track == "on"},
        detector_(columns_.track ? std::nullopt
                                 : std::make_optional(MakeSearcher<Detector>(arguments, options))),
        tracker_(columns_.track
                     ? std::make_optional(MakeSearcher<Tracker>(arguments, TrackerOptions{options}))
                     : std::nullopt),
        source_(arguments.inputs, ParseMaxPixels(arguments.max_pixels)),
        output_(arguments.output) {
    std::vector<std::string> files = source_.Files();
    files.push_back(arguments.camera);
    files.insert(files.end(), arguments.objects.begin(), arguments.objects.end());
    CheckOutputs({{"--output", arguments.output}}, files);
    files.push_back(arguments.output);
    taken_ = TakenFiles(files);
    if (!arguments.draw.empty()) draw_.emplace(arguments.draw, &taken_);
    if (!arguments.stages.empty()) stages_.emplace(arguments.stages, &taken_);
  }

  int Execute();

 private:
  /// @return false at the end.
  bool DetectNext();
  void Search();
  void WritePictures();

  const DetectArguments& arguments_;
  const Options& options_;
  ObjectFinder& objects_;
  const Format format_;
  const ExtraColumns columns_;
  std::optional<Detector> detector_;  ///< or:
  std::optional<Tracker> tracker_;
  size_t tracked_input_ = 0;
  FrameSource source_;
  OutputStream output_;
  TakenFiles taken_{{}};
  std::optional<PictureFolder> draw_;
  std::optional<PictureFolder> stages_;
  Frame frame_;
  FrameResult result_;
};

void Run::Search() {
  if (!tracker_) {
    detector_->detect(frame_.pixels, &result_.detections);
    result_.backend = detector_->backend();
    result_.times = detector_->times();
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
  if (options_.camera) source_.CheckSize(frame_, *options_.camera, arguments_.camera);
  try {
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
    if (stages_) stages_->Write(frame_.stem, StagePictures(*detector_, frame_.pixels, picture));
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

ObjectFinder ReadObjects(const DetectArguments& arguments, bool choose_families, Options* options) {
  ObjectFinder objects(arguments.objects);
  if (objects.empty()) return objects;
  if (!options->camera) throw UsageError("--object: needs --camera");
  objects.SetOptions(choose_families, options);
  objects.SetCamera(*options->camera);
  return objects;
}

int RunDetect(const DetectArguments& arguments) {
  Options options = ParseOptions(arguments);
  ObjectFinder objects =
      ReadObjects(arguments, arguments.family == DetectArguments().family, &options);
  const Format format = ParseFormat(arguments.format);
  if (arguments.track == "on" && !arguments.stages.empty()) {
    throw UsageError("--stages: not with --track on, which leaves out most of each frame");
  }
  return Run(arguments, options, &objects, format).Execute();
}

}  // namespace

Command AddDetect(CLI::App* app) {
  CLI::App* command = app->add_subcommand("detect", "Find markers in images, videos or a camera");
  const auto arguments = std::make_shared<DetectArguments>();
  AddDetectArguments(command, arguments.get());
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
