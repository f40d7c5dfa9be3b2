#include "host/backend.h"

#include <cstdlib>

#include "fallback/scalar_backend.h"
#include "topotag/error.h"

namespace topotag {
namespace {

constexpr char kBackendVariable[] = "TOPOTAG_BACKEND";

BackendKind Resolve(BackendKind kind) {
  if (kind != BackendKind::kAuto) return kind;
  const char* forced = std::getenv(kBackendVariable);
  if (forced == nullptr || *forced == '\0') return BackendKind::kScalar;
  try {
    kind = ParseBackend(forced);
  } catch (const Error& error) {
    throw Error(error.code(), std::string(kBackendVariable) + ": " + error.what());
  }
  return kind == BackendKind::kAuto ? BackendKind::kScalar : kind;
}

}  // namespace

std::unique_ptr<Backend> MakeBackend(BackendKind kind) {
  kind = Resolve(kind);
  if (kind == BackendKind::kScalar) return std::make_unique<scalar::ScalarBackend>();
  throw Error(ErrorCode::kUnavailable,
              std::string("backend '") + Name(kind) + "' is not in this build");
}

}  // namespace topotag
