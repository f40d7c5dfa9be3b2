#include <CLI/CLI.hpp>
#include <cstdio>
#include <opencv2/core/version.hpp>

#include "tools/command.h"
#include "tools/compiler.h"
#include "topotag/detector.h"
#include "topotag/device.h"

namespace topotag::tools {
namespace {

/// What a detector with this backend says of itself, or why there is none.
std::string Describe(BackendKind backend) {
  Options options;
  options.backend = backend;
  try {
    return "available: " + Detector(options).backend();
  } catch (const std::exception& error) {
    return std::string("not available: ") + error.what();
  }
}

void PrintDevices() {
  std::printf("OpenCL devices\n");
  try {
    const std::vector<DeviceInfo> devices = ListDevices();
    if (devices.empty()) std::printf("  none\n");
    for (const DeviceInfo& device : devices) {
      std::printf("  %-7d %s, %d compute units: %s; %s; %s\n", device.index, device.type.c_str(),
                  device.compute_units, device.name.c_str(), device.platform.c_str(),
                  device.version.c_str());
    }
  } catch (const Error& error) {
    std::printf("  %s\n", error.what());
  }
}

int RunInfo() {
  std::printf("topotag   %s\n", Version());
  std::printf("compiler  %s\n", kCompiler);
  std::printf("OpenCV    %s (files, video, drawing)\n", CV_VERSION);
  std::printf("backends\n");
  for (const BackendKind backend :
       {BackendKind::kAuto, BackendKind::kScalar, BackendKind::kSimd, BackendKind::kOpenCl}) {
    std::printf("  %-7s %s\n", Name(backend), Describe(backend).c_str());
  }
  PrintDevices();
  return kSuccess;
}

}  // namespace

Command AddInfo(CLI::App* app) {
  app->add_subcommand("info", "Print the version and what can be used here");
  return RunInfo;
}

}  // namespace topotag::tools
