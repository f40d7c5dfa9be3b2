#ifndef TOPOTAG_KERNELS_BUFFER_FRAMES_H_
#define TOPOTAG_KERNELS_BUFFER_FRAMES_H_

#include <CL/cl.h>

#include <cstdint>
#include <vector>

#include "host/buffer.h"
#include "host/frame_source.h"
#include "kernels/check.h"
#include "kernels/opencl_backend.h"
#include "topotag/opencl.h"

namespace topotag::opencl {

/// Frames in buffers of one context and device.
class BufferFrames : public FrameSource {
 public:
  /// @throws Error (kDevice)
  BufferFrames(const Device& device, cl_context context, std::unique_ptr<Backend> others);

  bool Serves(cl_context context, cl_device_id device) const {
    return backend_.context() == context && backend_.device() == device;
  }
  /// Makes this the current frame.
  /// @throws Error (kInvalidArgument, kDevice)
  void Set(const OpenClFrame& frame);
  /// Starts with a part of the current frame, which the backend binarizes next.
  void Submit(const Rect& area, const ThresholdParams& params);
  /// After which the current frame is no longer read.
  const Event& released() const { return read_; }

  Backend* backend() override { return &backend_; }
  ImageView shadow() const override;
  void Fetch(const std::vector<Rect>& parts) override;

 private:
  void EnqueueFetch(const Rect& part);

  OpenClBackend backend_;
  Queue queue_;  ///< of the transfers
  OpenClFrame frame_;
  Event ready_;  ///< after which the frame is complete
  Event read_;
  Buffer<uint8_t> shadow_;
};

}  // namespace topotag::opencl

#endif  // TOPOTAG_KERNELS_BUFFER_FRAMES_H_
