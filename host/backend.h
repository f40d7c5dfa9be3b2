#ifndef TOPOTAG_HOST_BACKEND_H_
#define TOPOTAG_HOST_BACKEND_H_

#include <memory>
#include <string>
#include <vector>

#include "host/pipeline.h"
#include "topotag/image.h"

namespace topotag {

/// The data-parallel stages. The scalar backend (fallback/) is their specification; every other
/// one gives the same bytes. One instance serves one thread.
class Backend {
 public:
  virtual ~Backend() = default;

  /// "scalar", "simd/AVX2", "opencl/<device>".
  virtual std::string name() const = 0;
  virtual void Threshold(const ImageView& image, const ThresholdParams& params,
                         ThresholdGrid* grid) = 0;
  virtual void Binarize(const ImageView& image, const ThresholdGrid& grid, BitImage* bits) = 0;
  virtual void Label(const BitImage& bits, Components* components) = 0;
  /// Features of the components with a nonzero `slot`, written to (*features)[slot]; slot has one
  /// entry a component, and features has an entry for every slot, reset by the caller.
  virtual void Measure(const Components& components, const std::vector<uint32_t>& slot,
                       std::vector<Feature>* features) = 0;
};

/// Resolves kAuto: the environment variable TOPOTAG_BACKEND, else the fastest backend built in.
/// @throws Error (kUnavailable, kInvalidArgument), naming the backend and why there is none.
std::unique_ptr<Backend> MakeBackend(BackendKind kind);

}  // namespace topotag

#endif  // TOPOTAG_HOST_BACKEND_H_
