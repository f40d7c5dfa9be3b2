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

double TagSize(const Options& options, Family family, uint64_t id) {
  const auto by_id = options.id_tag_size.find({family.n(), id});
  if (by_id != options.id_tag_size.end()) return by_id->second;
  const auto by_family = options.family_tag_size.find(family.n());
  return by_family != options.family_tag_size.end() ? by_family->second : options.tag_size;
}

int DefaultThreads() { return std::thread::hardware_concurrency() > 1 ? 2 : 1; }

}  // namespace topotag
