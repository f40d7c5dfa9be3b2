#include "kernels/frame_slot.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>

namespace topotag::opencl {
namespace {

// The kernels' vectors are one tile wide, and four rows share a row of thresholds.
static_assert(kTile == 16 && kRowsPerThreshold == 4 && kThresholdShift == 3);

// Work-items of a group: the same for all sizes of frames, because drivers build for them.
constexpr Items kSampleGroup = {8, 8};
constexpr Items kTileGroup = {16, 4};
constexpr Items kWordGroup = {4, 16};
constexpr int kPaperStride = 32;  // pixels between samples: s1 * s2
constexpr size_t kSlack = 16;     // kernels read 16 values at a time

size_t RoundUp(size_t n, size_t unit) { return (n + unit - 1) / unit * unit; }

Kernel MakeKernel(cl_program program, const char* name) {
  cl_int code = CL_SUCCESS;
  Kernel kernel(clCreateKernel(program, name, &code));
  TOPOTAG_CL_CODE(clCreateKernel, code);
  return kernel;
}

template <typename... Values>
void SetArguments(const Kernel& kernel, const Values&... values) {
  cl_uint index = 0;
  const auto set = [&](const auto& value) {
    TOPOTAG_CL(clSetKernelArg, kernel.get(), index++, sizeof(value), &value);
  };
  (set(values), ...);
}

double DeviceTime(const Event& from, const Event& to) {
  cl_ulong begin = 0;
  cl_ulong end = 0;
  TOPOTAG_CL(clGetEventProfilingInfo, from.get(), CL_PROFILING_COMMAND_START, sizeof(begin), &begin,
             nullptr);
  TOPOTAG_CL(clGetEventProfilingInfo, to.get(), CL_PROFILING_COMMAND_END, sizeof(end), &end,
             nullptr);
  return end < begin ? 0 : static_cast<double>(end - begin) * 1e-3;
}

size_t Words(int width) { return (static_cast<size_t>(width) + 63) / 64; }

}  // namespace

void DeviceBuffer::Reserve(cl_context context, cl_mem_flags flags, size_t bytes) {
  if (bytes <= size_) return;
  memory_.Reset();
  size_ = 0;
  cl_int code = CL_SUCCESS;
  memory_ = Memory(clCreateBuffer(context, flags, bytes, nullptr, &code));
  TOPOTAG_CL_CODE(clCreateBuffer, code);
  size_ = bytes;
}

void PinnedBuffer::Reserve(cl_context context, cl_command_queue queue, size_t bytes) {
  if (bytes <= buffer_.size() && data_ != nullptr) return;
  Unmap();
  buffer_.Reserve(context, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, bytes);
  queue_ = queue;
  cl_int code = CL_SUCCESS;
  data_ = clEnqueueMapBuffer(queue, buffer_.get(), CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, bytes, 0,
                             nullptr, nullptr, &code);
  TOPOTAG_CL_CODE(clEnqueueMapBuffer, code);
}

void PinnedBuffer::Unmap() {
  // In a destructor too, where a failure leaves nothing to do.
  if (data_ != nullptr) {
    clEnqueueUnmapMemObject(queue_, buffer_.get(), data_, 0, nullptr, nullptr);
  }
  data_ = nullptr;
}

FrameSlot::FrameSlot(const Engine& engine) : engine_(engine) {
  cl_int code = CL_SUCCESS;
  queue_ =
      Queue(clCreateCommandQueue(engine.context, engine.device, CL_QUEUE_PROFILING_ENABLE, &code));
  TOPOTAG_CL_CODE(clCreateCommandQueue, code);
  kernels_ = {MakeKernel(engine.program, "TileExtremes"), MakeKernel(engine.program, "DefaultGrid"),
              MakeKernel(engine.program, "PaperSamples"), MakeKernel(engine.program, "PaperGrid"),
              MakeKernel(engine.program, "Binarize")};
}

FrameSlot::~FrameSlot() { Finish(); }

// In destructors and after errors: a failure leaves nothing to do.
void FrameSlot::Finish() {
  clFinish(queue_.get());
  if (mapped_bits_ != nullptr) {
    clEnqueueUnmapMemObject(queue_.get(), bits_.get(), mapped_bits_, 0, nullptr, nullptr);
    clFinish(queue_.get());
    mapped_bits_ = nullptr;
  }
  mapped_image_.Reset();
}

void FrameSlot::Start(const ImageView& image, const ThresholdParams& params) {
  Resize(image.width, image.height, params.preset);
  try {
    Launch(Upload(image), params, nullptr);
  } catch (...) {
    // What is queued already reads the caller's frame.
    Finish();
    throw;
  }
}

void FrameSlot::Start(const BufferFrame& frame, const ThresholdParams& params, cl_event wait_for,
                      Event* read) {
  Resize(frame.width, frame.height, params.preset);
  try {
    Launch(frame, params, wait_for);
    TOPOTAG_CL(clRetainEvent, binarized_.get());
    *read = Event(binarized_.get());
  } catch (...) {
    Finish();
    throw;
  }
}

void FrameSlot::Resize(int width, int height, Preset preset) {
  width_ = width;
  height_ = height;
  cols_ = (width + kTile - 1) / kTile + 1;
  rows_ = (height + kTile - 1) / kTile + 1;
  pitch_ = static_cast<int>(RoundUp(static_cast<size_t>(cols_) + 1, 16));
  const size_t pitch = static_cast<size_t>(pitch_);
  const cl_mem_flags flags = CL_MEM_READ_WRITE | CL_MEM_HOST_NO_ACCESS;
  if (preset == Preset::kDefault) {
    tile_min_.Reserve(engine_.context, flags, pitch * TileRows());
    tile_max_.Reserve(engine_.context, flags, pitch * TileRows());
  }
  // All levels above the grid have less than half its cells, and a row and a column more; the
  // samples of the preset `paper` are fewer.
  const size_t pyramid = static_cast<size_t>(cols_ + 32) * static_cast<size_t>(rows_ + 32) / 2;
  pyramid_.Reserve(engine_.context, flags, (pyramid + kSlack) * sizeof(cl_ushort));
  grid_.Reserve(engine_.context, CL_MEM_READ_WRITE,
                (pitch * static_cast<size_t>(rows_) + kSlack) * sizeof(cl_ushort));
  const size_t tiles = pitch * static_cast<size_t>(rows_);
  floors_.Reserve(engine_.context, CL_MEM_READ_WRITE, tiles + kSlack);
  ceilings_.Reserve(engine_.context, CL_MEM_READ_WRITE, tiles + kSlack);
  const size_t bytes = Words(width) * static_cast<size_t>(height) * sizeof(cl_ulong);
  const bool mapped = engine_.transfer == Transfer::kMapped;
  bits_.Reserve(engine_.context, CL_MEM_READ_WRITE | (mapped ? CL_MEM_ALLOC_HOST_PTR : 0), bytes);
  if (!mapped) bits_staging_.Reserve(engine_.context, queue_.get(), bytes);
}

// Rows of the tile planes: two more than tiles, and whole groups, because each work-item writes.
size_t FrameSlot::TileRows() const { return RoundUp(static_cast<size_t>(rows_) + 2, kTileGroup.y); }

BufferFrame FrameSlot::Upload(const ImageView& image) {
  const size_t width = static_cast<size_t>(image.width);
  const size_t height = static_cast<size_t>(image.height);
  if (engine_.transfer == Transfer::kMapped) {
    const size_t stride = static_cast<size_t>(image.stride);
    cl_int code = CL_SUCCESS;
    mapped_image_ = Memory(clCreateBuffer(
        engine_.context, CL_MEM_READ_ONLY | CL_MEM_USE_HOST_PTR | CL_MEM_HOST_NO_ACCESS,
        stride * (height - 1) + width, const_cast<uint8_t*>(image.data), &code));
    TOPOTAG_CL_CODE(clCreateBuffer, code);
    return {mapped_image_.get(), 0, image.width, image.height, stride};
  }
  const size_t stride = RoundUp(width, 64);
  const size_t bytes = stride * height;
  image_.Reserve(engine_.context, CL_MEM_READ_ONLY, bytes);
  image_staging_.Reserve(engine_.context, queue_.get(), bytes);
  uint8_t* staging = static_cast<uint8_t*>(image_staging_.data());
  for (int y = 0; y < image.height; ++y) {
    std::memcpy(staging + static_cast<size_t>(y) * stride, image.row(y), width);
  }
  TOPOTAG_CL(clEnqueueWriteBuffer, queue_.get(), image_.get(), CL_FALSE, 0, bytes, staging, 0,
             nullptr, nullptr);
  return {image_.get(), 0, image.width, image.height, stride};
}

void FrameSlot::Launch(const BufferFrame& frame, const ThresholdParams& params, cl_event wait_for) {
  if (params.preset == Preset::kPaper) {
    LaunchPaper(frame, params, wait_for);
  } else {
    LaunchDefault(frame, params, wait_for);
  }
  SetArguments(kernels_.binarize, frame.buffer, cl_ulong{frame.offset}, cl_ulong{frame.stride},
               cl_int{width_}, cl_int{height_}, grid_.get(), floors_.get(), ceilings_.get(),
               cl_int{pitch_}, cl_int{engine_.item_rows}, bits_.get());
  const size_t item_rows = static_cast<size_t>(engine_.item_rows);
  const size_t groups = (static_cast<size_t>(height_) + item_rows - 1) / item_rows;
  Run(kernels_.binarize, {Words(width_), groups}, kWordGroup, nullptr, &binarized_);
  Download();
}

void FrameSlot::LaunchDefault(const BufferFrame& frame, const ThresholdParams& params,
                              cl_event wait_for) {
  SetArguments(kernels_.tile_extremes, frame.buffer, cl_ulong{frame.offset}, cl_ulong{frame.stride},
               cl_int{width_}, cl_int{height_}, cl_int{pitch_}, tile_min_.get(), tile_max_.get());
  Run(kernels_.tile_extremes, {static_cast<size_t>(pitch_), TileRows()}, kTileGroup, wait_for,
      &first_done_);
  SetArguments(kernels_.default_grid, tile_min_.get(), tile_max_.get(), cl_int{cols_},
               cl_int{rows_}, cl_int{pitch_}, cl_int{params.min_contrast},
               cl_int{params.contrast_sixteenths}, pyramid_.get(), grid_.get(), floors_.get(),
               ceilings_.get());
  Run(kernels_.default_grid, engine_.grid_group, engine_.grid_group, nullptr, &grid_done_);
}

void FrameSlot::LaunchPaper(const BufferFrame& frame, const ThresholdParams& params,
                            cl_event wait_for) {
  const cl_int sample_cols = (width_ - 1) / kPaperStride + 1;
  const cl_int sample_rows = (height_ - 1) / kPaperStride + 1;
  SetArguments(kernels_.paper_samples, frame.buffer, cl_ulong{frame.offset}, cl_ulong{frame.stride},
               cl_int{width_}, cl_int{height_}, sample_cols, sample_rows, cl_int{params.alpha},
               cl_int{params.beta << kThresholdShift}, cl_int{params.bin_factor_percent},
               pyramid_.get());
  Run(kernels_.paper_samples, {static_cast<size_t>(sample_cols), static_cast<size_t>(sample_rows)},
      kSampleGroup, wait_for, &first_done_);
  SetArguments(kernels_.paper_grid, pyramid_.get(), sample_cols, sample_rows, cl_int{cols_},
               cl_int{rows_}, cl_int{pitch_}, grid_.get(), floors_.get(), ceilings_.get());
  Run(kernels_.paper_grid, {static_cast<size_t>(cols_), static_cast<size_t>(rows_)}, kTileGroup,
      nullptr, &grid_done_);
}

void FrameSlot::Run(const Kernel& kernel, const Items& items, const Items& group, cl_event wait_for,
                    Event* done) {
  const size_t global[2] = {RoundUp(items.x, group.x), RoundUp(items.y, group.y)};
  const size_t local[2] = {group.x, group.y};
  TOPOTAG_CL(clEnqueueNDRangeKernel, queue_.get(), kernel.get(), 2, nullptr, global, local,
             wait_for == nullptr ? 0 : 1, wait_for == nullptr ? nullptr : &wait_for, done->out());
}

void FrameSlot::Download() {
  const size_t bytes = Words(width_) * static_cast<size_t>(height_) * sizeof(cl_ulong);
  if (engine_.transfer == Transfer::kMapped) {
    cl_int code = CL_SUCCESS;
    mapped_bits_ = clEnqueueMapBuffer(queue_.get(), bits_.get(), CL_FALSE, CL_MAP_READ, 0, bytes, 0,
                                      nullptr, arrived_.out(), &code);
    TOPOTAG_CL_CODE(clEnqueueMapBuffer, code);
  } else {
    TOPOTAG_CL(clEnqueueReadBuffer, queue_.get(), bits_.get(), CL_FALSE, 0, bytes,
               bits_staging_.data(), 0, nullptr, arrived_.out());
  }
  TOPOTAG_CL(clFlush, queue_.get());
}

void FrameSlot::Collect(BitImage* bits) {
  try {
    Take(bits);
  } catch (...) {
    Finish();
    throw;
  }
}

void FrameSlot::Take(BitImage* bits) {
  const cl_event arrived = arrived_.get();
  TOPOTAG_CL(clWaitForEvents, 1, &arrived);
  bits->Resize(width_, height_);
  const bool mapped = engine_.transfer == Transfer::kMapped;
  std::memcpy(bits->row(0), mapped ? mapped_bits_ : bits_staging_.data(),
              bits->size() * sizeof(uint64_t));
  if (!mapped) return;
  void* const unmapped = std::exchange(mapped_bits_, nullptr);
  TOPOTAG_CL(clEnqueueUnmapMemObject, queue_.get(), bits_.get(), unmapped, 0, nullptr, nullptr);
  mapped_image_.Reset();
}

double FrameSlot::ThresholdTime() const { return DeviceTime(first_done_, grid_done_); }

void FrameSlot::ReadGrid(ThresholdGrid* grid) {
  grid->Resize(width_, height_);
  const size_t cols = static_cast<size_t>(cols_);
  const size_t rows = static_cast<size_t>(rows_);
  ReadPlane(grid_, cols, rows, sizeof(uint16_t), grid->value.data());
  ReadPlane(floors_, cols - 1, rows - 1, 1, grid->floor.data());
  ReadPlane(ceilings_, cols - 1, rows - 1, 1, grid->ceiling.data());
}

void FrameSlot::ReadPlane(const DeviceBuffer& plane, size_t cols, size_t rows, size_t value_size,
                          void* out) {
  const size_t origin[3] = {0, 0, 0};
  const size_t region[3] = {cols * value_size, rows, 1};
  TOPOTAG_CL(clEnqueueReadBufferRect, queue_.get(), plane.get(), CL_TRUE, origin, origin, region,
             static_cast<size_t>(pitch_) * value_size, 0, region[0], 0, out, 0, nullptr, nullptr);
}

}  // namespace topotag::opencl
