#ifndef TOPOTAG_KERNELS_FRAME_SLOT_H_
#define TOPOTAG_KERNELS_FRAME_SLOT_H_

#include <CL/cl.h>

#include <cstddef>

#include "host/pipeline.h"
#include "kernels/check.h"
#include "topotag/image.h"

namespace topotag::opencl {

/// How host memory and a device exchange data.
enum class Transfer {
  kMapped,  ///< they are the same memory: no copy of the frame is made
  kStaged,  ///< through pinned memory of the driver, by transfers that nobody waits for
};

/// A frame that is in the memory of the device.
struct BufferFrame {
  cl_mem buffer;
  size_t offset;  ///< of the first pixel, bytes
  int width, height;
  size_t stride;  ///< bytes, >= width
};

/// Work-items, of a launch or of a group.
struct Items {
  size_t x, y;
};

/// What all slots of a Binarizer share.
struct Engine {
  cl_context context;
  cl_device_id device;
  cl_program program;
  Transfer transfer;
  int item_rows;     ///< rows that one work-item binarizes
  Items grid_group;  ///< the one group that computes the grid of the default preset
};

/// Device memory that grows and never shrinks.
class DeviceBuffer {
 public:
  void Reserve(cl_context context, cl_mem_flags flags, size_t bytes);
  cl_mem get() const { return memory_.get(); }
  size_t size() const { return size_; }

 private:
  Memory memory_;
  size_t size_ = 0;
};

/// Memory of the driver that stays mapped: transfers from and to it need no copy.
class PinnedBuffer {
 public:
  PinnedBuffer() = default;
  ~PinnedBuffer() { Unmap(); }
  PinnedBuffer(const PinnedBuffer&) = delete;
  PinnedBuffer& operator=(const PinnedBuffer&) = delete;

  /// `queue` must outlive this.
  void Reserve(cl_context context, cl_command_queue queue, size_t bytes);
  void* data() const { return data_; }

 private:
  void Unmap();

  DeviceBuffer buffer_;
  cl_command_queue queue_ = nullptr;
  void* data_ = nullptr;
};

/// One frame on its way through the device: a queue of its own, in order, and all buffers.
class FrameSlot {
 public:
  explicit FrameSlot(const Engine& engine);
  /// Waits for what is under way: it reads the caller's frame.
  ~FrameSlot();

  /// Starts a frame. It stays as it is until Collect.
  void Start(const ImageView& image, const ThresholdParams& params);
  /// The same for a frame on the device, after `wait_for` (may be null). The caller owns *read, an
  /// event after which the frame is no longer needed.
  void Start(const BufferFrame& frame, const ThresholdParams& params, cl_event wait_for,
             Event* read);

  /// Waits for the frame's bits.
  void Collect(BitImage* bits);
  /// Instead of Collect: waits for what reads the frame. A failure leaves nothing to do.
  void Finish();
  /// Device time of the collected frame's threshold map, microseconds.
  double ThresholdTime() const;
  /// Threshold map of the collected frame.
  void ReadGrid(ThresholdGrid* grid);

 private:
  struct Kernels {
    Kernel tile_extremes, default_grid, paper_samples, paper_grid, binarize;
  };

  void Resize(int width, int height, Preset preset);
  size_t TileRows() const;
  BufferFrame Upload(const ImageView& image);
  void Launch(const BufferFrame& frame, const ThresholdParams& params, cl_event wait_for);
  void LaunchDefault(const BufferFrame& frame, const ThresholdParams& params, cl_event wait_for);
  void LaunchPaper(const BufferFrame& frame, const ThresholdParams& params, cl_event wait_for);
  void Download();
  void Take(BitImage* bits);
  void ReadPlane(const DeviceBuffer& plane, size_t cols, size_t rows, size_t value_size, void* out);
  void Run(const Kernel& kernel, const Items& items, const Items& group, cl_event wait_for,
           Event* done);

  const Engine& engine_;
  Queue queue_;
  Kernels kernels_;

  int width_ = 0, height_ = 0;
  int cols_ = 0, rows_ = 0, pitch_ = 0;  ///< of the grid; kernels/threshold.cl
  Memory mapped_image_;
  DeviceBuffer image_, tile_min_, tile_max_, pyramid_, grid_, floors_, ceilings_, bits_;
  PinnedBuffer image_staging_, bits_staging_;
  Event first_done_, grid_done_, binarized_, arrived_;
  void* mapped_bits_ = nullptr;  ///< while they are mapped
};

}  // namespace topotag::opencl

#endif  // TOPOTAG_KERNELS_FRAME_SLOT_H_
