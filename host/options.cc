#include "topotag/options.h"

#include <string>
#include <thread>

#include "host/check.h"

namespace topotag {
namespace {

[[noreturn]] void Unknown(const char* what, const std::string& name, const char* expected) {
  FailArgument(std::string("unknown ") + what + " '" + name + "': expected one of " + expected);
}

}  // namespace

BackendKind ParseBackend(const std::string& name) {
  for (BackendKind kind :
       {BackendKind::kAuto, BackendKind::kScalar, BackendKind::kSimd, BackendKind::kOpenCl}) {
    if (name == Name(kind)) return kind;
  }
  Unknown("backend", name, "auto, simd, opencl, scalar");
}

const char* Name(BackendKind backend) {
  switch (backend) {
    case BackendKind::kScalar:
      return "scalar";
    case BackendKind::kSimd:
      return "simd";
    case BackendKind::kOpenCl:
      return "opencl";
    case BackendKind::kAuto:
      break;
  }
  return "auto";
}

Preset ParsePreset(const std::string& name) {
  if (name == "default") return Preset::kDefault;
  if (name == "paper") return Preset::kPaper;
  Unknown("preset", name, "default, paper");
}

PoseMode ParsePoseMode(const std::string& name) {
  for (const PoseMode mode : {PoseMode::kVertices, PoseMode::kPhotometric}) {
    if (name == Name(mode)) return mode;
  }
  Unknown("pose mode", name, "vertices, photometric");
}

const char* Name(PoseMode mode) {
  return mode == PoseMode::kPhotometric ? "photometric" : "vertices";
}

int DefaultThreads() { return std::thread::hardware_concurrency() > 1 ? 2 : 1; }

}  // namespace topotag
