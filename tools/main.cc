#include <signal.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <opencv2/core/utils/logger.hpp>

#include "tools/command.h"
#include "tools/help.h"
#include "tools/output.h"
#include "topotag/detector.h"
#include "topotag/error.h"

namespace topotag::tools {
namespace {

/// What goes wrong is told in the tool's own words, one line each.
void SilenceLibraries() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  setenv("GST_DEBUG", "0", 0);
  // A frame that a file ends in the middle of is not decoded into half a picture.
  setenv("OPENCV_FFMPEG_CAPTURE_OPTIONS", "fflags;discardcorrupt", 0);
  // A reader that has gone, or a file as large as may be, is an error of the write, which says so.
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);
}

/// Standard output may be a full disk or a reader that has gone. `earlier`: errno of a write that
/// went by way of a library.
int FlushStdout(int status, int earlier = 0) {
  errno = earlier;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  if (errno == EPIPE || errno == 0) return status;
  Complain(std::string("standard output: cannot be written: ") + std::strerror(errno));
  return kFailure;
}

int RunCommand(const Command& command) {
  try {
    return FlushStdout(command());
  } catch (const BrokenPipe&) {
    return kSuccess;
  } catch (const UsageError& error) {
    Complain(error.what());
    return kUsage;
  } catch (const std::exception& error) {
    Complain(Describe(error));
    return kFailure;
  }
}

int Main(int argc, char** argv) {
  SilenceLibraries();
  CLI::App app("TopoTag fiducial markers: detect, print and render them.", "topotag");
  app.formatter(std::make_shared<HelpFormatter>());  // the commands inherit it
  app.set_version_flag("--version", std::string("topotag ") + Version());
  app.require_subcommand(0, 1);
  app.footer(
      "topotag COMMAND --help explains a command.\n"
      "Exit status: 0 all done, 1 a file could not be read or written, 2 wrong usage,\n"
      "128 + N ended by signal N.");
  const Command detect = AddDetect(&app);
  const Command generate = AddGenerate(&app);
  const Command render = AddRender(&app);
  const Command bench = AddBench(&app);
  const Command object = AddObject(&app);
  const Command info = AddInfo(&app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
      errno = 0;
      app.exit(error);
      return FlushStdout(kSuccess, errno);
    }
    Complain(error.what());
    return kUsage;
  }
  if (app.got_subcommand("detect")) return RunCommand(detect);
  if (app.got_subcommand("generate")) return RunCommand(generate);
  if (app.got_subcommand("render")) return RunCommand(render);
  if (app.got_subcommand("bench")) return RunCommand(bench);
  if (app.got_subcommand("object")) return RunCommand(object);
  if (app.got_subcommand("info")) return RunCommand(info);
  Complain(
      "a command is missing: detect, generate, render, bench, object or info; see topotag --help");
  return kUsage;
}

}  // namespace
}  // namespace topotag::tools

int main(int argc, char** argv) {
  try {
    return topotag::tools::Main(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("topotag: not enough memory\n", stderr);
  } catch (const std::exception& error) {
    topotag::tools::Complain(error.what());
  }
  return topotag::tools::kFailure;
}
