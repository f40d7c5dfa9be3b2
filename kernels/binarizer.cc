#include "kernels/binarizer.h"

#include <algorithm>

#include "kernels/program.h"
#include "topotag/error.h"

namespace topotag::opencl {
namespace {

constexpr size_t kGridGroupSide = 16;

Context OwnContext(cl_device_id device) {
  cl_int code = CL_SUCCESS;
  Context context(clCreateContext(nullptr, 1, &device, nullptr, nullptr, &code));
  TOPOTAG_CL_CODE(clCreateContext, code);
  return context;
}

Context Shared(cl_context context) {
  TOPOTAG_CL(clRetainContext, context);
  return Context(context);
}

void RequireLittleEndian(const Device& device) {
  cl_bool little = CL_FALSE;
  TOPOTAG_CL(clGetDeviceInfo, device.id, CL_DEVICE_ENDIAN_LITTLE, sizeof(little), &little, nullptr);
  if (little == CL_FALSE) {
    throw Error(ErrorCode::kUnavailable,
                "OpenCL: " + device.info.name + " is big-endian, which the kernels do not support");
  }
}

bool IsCpu(const Device& device) { return (device.type & CL_DEVICE_TYPE_CPU) != 0; }

// Much work an item spares a CPU overhead; many items keep a GPU busy.
int ItemRows(const Device& device) { return IsCpu(device) ? kTile : kRowsPerThreshold; }

// The group that computes the grid. A CPU runs its work-items one after the other: one is enough.
Items GridGroup(const Device& device, cl_program program) {
  if (IsCpu(device)) return {1, 1};
  cl_int code = CL_SUCCESS;
  const Kernel kernel(clCreateKernel(program, "DefaultGrid", &code));
  TOPOTAG_CL_CODE(clCreateKernel, code);
  size_t most = 1;
  TOPOTAG_CL(clGetKernelWorkGroupInfo, kernel.get(), device.id, CL_KERNEL_WORK_GROUP_SIZE,
             sizeof(most), &most, nullptr);
  size_t side = kGridGroupSide;
  while (side * side > most) side /= 2;
  return {side, side};
}

}  // namespace

Transfer Binarizer::DefaultTransfer(const Device& device) {
  return IsCpu(device) ? Transfer::kMapped : Transfer::kStaged;
}

Binarizer::Binarizer(const Device& device, cl_context context, Transfer transfer)
    : device_(device), context_(context == nullptr ? OwnContext(device.id) : Shared(context)) {
  RequireLittleEndian(device);
  program_ = BuildProgram(context_.get(), device);
  engine_ = {context_.get(), device.id,        program_.get(),
             transfer,       ItemRows(device), GridGroup(device, program_.get())};
  for (std::optional<FrameSlot>& slot : slots_) slot.emplace(engine_);
}

FrameSlot& Binarizer::Next() {
  if (submitted_ == Backend::kMaxSubmitted) {
    throw Error(ErrorCode::kInvalidArgument,
                "OpenCL: " + std::to_string(submitted_) + " frames are under way already");
  }
  return *slots_[(collected_ + submitted_ + 1) % kSlots];
}

void Binarizer::Submit(const ImageView& image, const ThresholdParams& params) {
  Next().Start(image, params);
  ++submitted_;
}

void Binarizer::Submit(const BufferFrame& frame, const ThresholdParams& params, cl_event wait_for,
                       Event* read) {
  Next().Start(frame, params, wait_for, read);
  ++submitted_;
}

FrameSlot& Binarizer::TakeOldest() {
  collected_ = (collected_ + 1) % kSlots;
  --submitted_;
  return Collected();
}

void Binarizer::Collect(BitImage* bits) {
  if (submitted_ == 0) throw Error(ErrorCode::kInvalidArgument, "OpenCL: no frame is under way");
  TakeOldest().Collect(bits);
}

void Binarizer::Drop() { TakeOldest().Finish(); }

}  // namespace topotag::opencl
