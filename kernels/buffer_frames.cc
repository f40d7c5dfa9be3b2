#include "kernels/buffer_frames.h"

#include <utility>

#include "host/check.h"
#include "topotag/error.h"

namespace topotag::opencl {
namespace {

// Handles of something else work with some drivers for a while.
void RequireBuffer(const OpenClFrame& frame, cl_context context) {
  cl_mem_object_type type = 0;
  cl_context of_buffer = nullptr, of_event = context;
  TOPOTAG_CL(clGetMemObjectInfo, frame.buffer, CL_MEM_TYPE, sizeof(type), &type, nullptr);
  if (type != CL_MEM_OBJECT_BUFFER) FailArgument("the frame's memory object is not a buffer");
  TOPOTAG_CL(clGetMemObjectInfo, frame.buffer, CL_MEM_CONTEXT, sizeof(of_buffer), &of_buffer,
             nullptr);
  if (of_buffer != context) FailArgument("the frame's buffer is of another context than its queue");
  if (frame.wait_for == nullptr) return;
  TOPOTAG_CL(clGetEventInfo, frame.wait_for, CL_EVENT_CONTEXT, sizeof(of_event), &of_event,
             nullptr);
  if (of_event != context) FailArgument("the frame's event is of another context than its queue");
  cl_int status = 0;
  TOPOTAG_CL(clGetEventInfo, frame.wait_for, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof(status),
             &status, nullptr);
  if (status < 0) {
    throw Error(ErrorCode::kDevice,
                "OpenCL: the event to wait for has failed with " + std::to_string(status));
  }
}

void RequireFits(const OpenClFrame& frame) {
  size_t size = 0;
  TOPOTAG_CL(clGetMemObjectInfo, frame.buffer, CL_MEM_SIZE, sizeof(size), &size, nullptr);
  const size_t width = static_cast<size_t>(frame.width);
  const size_t rows = static_cast<size_t>(frame.height) - 1;
  // Divided, because the product may not fit.
  if (frame.offset > size || width > size - frame.offset ||
      (rows > 0 && frame.stride > (size - frame.offset - width) / rows)) {
    FailArgument("the frame reaches beyond its buffer of " + std::to_string(size) + " bytes");
  }
}

}  // namespace

BufferFrames::BufferFrames(const Device& device, cl_context context,
                           std::unique_ptr<Backend> others)
    : backend_(device, context, std::move(others)) {
  cl_int code = CL_SUCCESS;
  queue_ = Queue(clCreateCommandQueue(context, device.id, 0, &code));
  TOPOTAG_CL_CODE(clCreateCommandQueue, code);
}

void BufferFrames::Set(const OpenClFrame& frame) {
  RequireBuffer(frame, backend_.context());
  RequireFits(frame);
  frame_ = frame;
  shadow_.Reserve(static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height));
  if (frame.wait_for != nullptr) {
    TOPOTAG_CL(clRetainEvent, frame.wait_for);
    ready_ = Event(frame.wait_for);
  } else {
    TOPOTAG_CL(clEnqueueMarkerWithWaitList, frame.queue, 0, nullptr, ready_.out());
    TOPOTAG_CL(clFlush, frame.queue);
  }
}

void BufferFrames::Submit(const Rect& area, const ThresholdParams& params) {
  const size_t offset =
      frame_.offset + static_cast<size_t>(area.y) * frame_.stride + static_cast<size_t>(area.x);
  backend_.Submit(BufferFrame{frame_.buffer, offset, area.width, area.height, frame_.stride},
                  params, ready_.get(), &read_);
}

ImageView BufferFrames::shadow() const {
  return {shadow_.data(), frame_.width, frame_.height, frame_.width};
}

// The bits have arrived when pixels are fetched: nothing is left to wait for but the transfers.
void BufferFrames::Fetch(const std::vector<Rect>& parts) {
  if (parts.empty()) return;
  try {
    for (const Rect& part : parts) EnqueueFetch(part);
  } catch (...) {
    // What is queued already writes to the shadow.
    clFinish(queue_.get());
    throw;
  }
  TOPOTAG_CL(clFinish, queue_.get());
}

void BufferFrames::EnqueueFetch(const Rect& part) {
  const size_t device_origin[3] = {static_cast<size_t>(part.x), static_cast<size_t>(part.y), 0};
  const size_t region[3] = {static_cast<size_t>(part.width), static_cast<size_t>(part.height), 1};
  // The frame's offset, which need not be a multiple of the stride, is split over both.
  size_t origin[3] = {device_origin[0] + frame_.offset % frame_.stride,
                      device_origin[1] + frame_.offset / frame_.stride, 0};
  TOPOTAG_CL(clEnqueueReadBufferRect, queue_.get(), frame_.buffer, CL_FALSE, origin, device_origin,
             region, frame_.stride, 0, static_cast<size_t>(frame_.width), 0, shadow_.data(), 0,
             nullptr, read_.out());
}

}  // namespace topotag::opencl
