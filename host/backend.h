#ifndef TOPOTAG_HOST_BACKEND_H_
#define TOPOTAG_HOST_BACKEND_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "host/pipeline.h"
#include "topotag/detector.h"
#include "topotag/image.h"

namespace topotag {

class Workers;

/// The data-parallel stages. The scalar backend (fallback/) is their specification; every other
/// one gives the same bytes. One instance serves one thread at a time.
class Backend {
 public:
  virtual ~Backend() = default;

  /// "scalar", "simd/AVX2", "opencl/<device>".
  virtual std::string name() const = 0;

  /// Begins with a frame whose Binarize comes later, where the backend can work ahead. Frames are
  /// binarized in the order in which they were submitted; kMaxSubmitted at a time. The image stays
  /// the caller's and unchanged until then.
  virtual void Submit(const ImageView& image, const ThresholdParams& params);
  static constexpr int kMaxSubmitted = 2;
  /// Drops the oldest submitted frames until `count` are left, at most: after an error, those that
  /// nobody waits for. Nothing reads a dropped frame any more when this returns.
  virtual void KeepSubmitted(size_t count);

  /// The threshold map and the bit image of one frame: the oldest submitted one, if there is any.
  /// Adds the times of both stages to *times.
  virtual void Binarize(const ImageView& image, const ThresholdParams& params, BitImage* bits,
                        StageTimes* times) = 0;
  /// Threshold map of the last frame.
  virtual const ThresholdGrid& Grid() = 0;

  virtual void Label(const BitImage& bits, Components* components) = 0;

  /// Features of the components of which a label l has a nonzero slot[l], written to
  /// features[slot[l]]; `slots` entries, of which the first is not used. All labels of a component
  /// have the same slot; that of the outside is 0.
  virtual void Measure(const Components& components, const uint32_t* slot, size_t slots,
                       Feature* features) = 0;
};

/// Resolves kAuto: the environment variable TOPOTAG_BACKEND, else the fastest backend built in.
/// @param workers  shared by the backends of one detector, which run one after the other
/// @param device   of the opencl backend, Options::device
/// @throws Error (kUnavailable, kInvalidArgument), naming the backend and why there is none;
/// kDevice.
std::unique_ptr<Backend> MakeBackend(BackendKind kind, Workers* workers,
                                     std::optional<int> device = std::nullopt);
/// The backend of small areas: the same, but never a device. The way there and back takes longer.
std::unique_ptr<Backend> MakeSecondBackend(BackendKind kind, Workers* workers);

}  // namespace topotag

#endif  // TOPOTAG_HOST_BACKEND_H_
