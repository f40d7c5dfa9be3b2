#include "host/backend.h"

#include <cstdlib>

#include "fallback/scalar_backend.h"
#include "simd/simd_backend.h"
#include "topotag/device.h"
#include "topotag/error.h"

#ifdef TOPOTAG_HAVE_OPENCL
#include "kernels/device.h"
#include "kernels/opencl_backend.h"
#endif

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

#ifdef TOPOTAG_HAVE_OPENCL
std::unique_ptr<Backend> MakeOpenCl(Workers* workers, std::optional<int> device) {
  return std::make_unique<opencl::OpenClBackend>(opencl::ChooseDevice(device), nullptr,
                                                 std::make_unique<simd::SimdBackend>(workers));
}
#else
std::unique_ptr<Backend> MakeOpenCl(Workers*, std::optional<int>) {
  throw Error(ErrorCode::kUnavailable, "backend 'opencl' is not in this build (no OpenCL)");
}
#endif

}  // namespace

void Backend::Submit(const ImageView&, const ThresholdParams&) {}

void Backend::KeepSubmitted(size_t) {}

std::unique_ptr<Backend> MakeBackend(BackendKind kind, Workers* workers,
                                     std::optional<int> device) {
  kind = Resolve(kind);
  if (kind == BackendKind::kScalar) return std::make_unique<scalar::ScalarBackend>();
  if (kind == BackendKind::kOpenCl) return MakeOpenCl(workers, device);
  return std::make_unique<simd::SimdBackend>(workers);
}

std::unique_ptr<Backend> MakeSecondBackend(BackendKind kind, Workers* workers) {
  kind = Resolve(kind);
  return MakeBackend(kind == BackendKind::kOpenCl ? BackendKind::kSimd : kind, workers);
}

std::vector<DeviceInfo> ListDevices() {
  std::vector<DeviceInfo> list;
#ifdef TOPOTAG_HAVE_OPENCL
  for (const opencl::Device& device : opencl::AllDevices()) list.push_back(device.info);
#endif
  return list;
}

}  // namespace topotag
