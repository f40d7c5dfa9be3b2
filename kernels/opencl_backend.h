#ifndef TOPOTAG_KERNELS_OPENCL_BACKEND_H_
#define TOPOTAG_KERNELS_OPENCL_BACKEND_H_

#include <CL/cl.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "host/backend.h"
#include "kernels/binarizer.h"
#include "kernels/device.h"

namespace topotag::opencl {

/// The threshold map and the bits on an OpenCL device, the other stages on another backend.
class OpenClBackend : public Backend {
 public:
  /// @param context  of the device, or null: one of its own
  /// @param others   labels and measures
  /// @throws Error (kDevice: also where the device computes a test frame otherwise than the scalar
  ///         backend does)
  OpenClBackend(const Device& device, cl_context context, std::unique_ptr<Backend> others);

  std::string name() const override { return "opencl/" + binarizer_.device().info.name; }
  cl_context context() const { return binarizer_.context(); }
  cl_device_id device() const { return binarizer_.device().id; }

  void Submit(const ImageView& image, const ThresholdParams& params) override;
  /// A frame in a buffer of this context: Binarizer::Submit.
  void Submit(const BufferFrame& frame, const ThresholdParams& params, cl_event wait_for,
              Event* read) {
    binarizer_.Submit(frame, params, wait_for, read);
  }
  void KeepSubmitted(size_t count) override;
  /// The threshold map's time is the device's; the rest of the caller's time counts as
  /// binarization.
  void Binarize(const ImageView& image, const ThresholdParams& params, BitImage* bits,
                StageTimes* times) override;
  const ThresholdGrid& Grid() override;
  void Label(const BitImage& bits, Components* components) override;
  void Measure(const Components& components, const uint32_t* slot, size_t slots,
               Feature* features) override;

 private:
  Binarizer binarizer_;
  std::unique_ptr<Backend> others_;
  ThresholdGrid grid_;
  bool grid_is_read_ = false;
};

}  // namespace topotag::opencl

#endif  // TOPOTAG_KERNELS_OPENCL_BACKEND_H_
