#ifndef TOPOTAG_KERNELS_BINARIZER_H_
#define TOPOTAG_KERNELS_BINARIZER_H_

#include <CL/cl.h>

#include <optional>

#include "host/backend.h"
#include "host/pipeline.h"
#include "kernels/check.h"
#include "kernels/device.h"
#include "kernels/frame_slot.h"
#include "topotag/image.h"

namespace topotag::opencl {

/// The threshold map and the binarization on one device. Paper: section 4.1.
///
/// Up to Backend::kMaxSubmitted frames are under way at a time; they are collected in the order of
/// their submission. Every stage of a frame is queued at once: the host waits for the bits only.
/// All functions but Drop throw Error (kDevice).
class Binarizer {
 public:
  /// How the device is best fed: a CPU works on the caller's memory.
  static Transfer DefaultTransfer(const Device& device);

  /// @param context  of which the device is; null: one of its own.
  Binarizer(const Device& device, cl_context context, Transfer transfer);
  Binarizer(const Binarizer&) = delete;
  Binarizer& operator=(const Binarizer&) = delete;

  const Device& device() const { return device_; }
  cl_context context() const { return context_.get(); }

  /// The image stays as it is until it has been collected.
  void Submit(const ImageView& image, const ThresholdParams& params);
  /// A frame in a buffer of this context. Work begins after `wait_for` (may be null); *read, which
  /// the caller releases, is an event after which the frame is no longer read.
  void Submit(const BufferFrame& frame, const ThresholdParams& params, cl_event wait_for,
              Event* read);
  int submitted() const { return submitted_; }

  /// The bits of the oldest submitted frame.
  void Collect(BitImage* bits);
  /// Does without the oldest submitted frame, of which there is one, but waits for what reads it.
  void Drop();
  /// Of the frame collected last: device time of its threshold map, microseconds, and the map.
  double ThresholdTime() const { return Collected().ThresholdTime(); }
  void ReadGrid(ThresholdGrid* grid) { Collected().ReadGrid(grid); }

 private:
  // One more than can be under way: the map of the frame collected last can still be read.
  static constexpr int kSlots = Backend::kMaxSubmitted + 1;

  FrameSlot& Next();
  FrameSlot& TakeOldest();
  FrameSlot& Collected() { return *slots_[collected_]; }
  const FrameSlot& Collected() const { return *slots_[collected_]; }

  Device device_;
  Context context_;
  Program program_;
  Engine engine_;
  std::optional<FrameSlot> slots_[kSlots];
  int submitted_ = 0;
  int collected_ = 0;  ///< slot of the frame collected last; the submitted ones follow
};

}  // namespace topotag::opencl

#endif  // TOPOTAG_KERNELS_BINARIZER_H_
