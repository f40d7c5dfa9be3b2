#include "host/backend.h"

#include <cstdlib>

#include "fallback/scalar_backend.h"
#include "simd/simd_backend.h"
#include "topotag/error.h"

namespace topotag {
namespace {

constexpr char kBackendVariable[] = "TOPOTAG_BACKEND";

BackendKind Resolve(BackendKind kind) {
  if (kind != BackendKind::kAuto) return kind;
  const char* forced = std::getenv(kBackendVariable);
  if (forced == nullptr || *forced == '\0') return BackendKind::kSimd;
  try {
    kind = ParseBackend(forced);
  } catch (const Error& error) {
    throw Error(error.code(), std::string(kBackendVariable) + ": " + error.what());
  }
  return kind == BackendKind::kAuto ? BackendKind::kSimd : kind;
}

}  // namespace

void Backend::Submit(const ImageView&, const ThresholdParams&) {}

std::unique_ptr<Backend> MakeBackend(BackendKind kind, Workers* workers) {
  kind = Resolve(kind);
  if (kind == BackendKind::kScalar) return std::make_unique<scalar::ScalarBackend>();
  if (kind == BackendKind::kSimd) return std::make_unique<simd::SimdBackend>(workers);
  throw Error(ErrorCode::kUnavailable,
              std::string("backend '") + Name(kind) + "' is not in this build");
}

}  // namespace topotag
