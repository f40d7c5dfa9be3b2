#include "topotag/opencl.h"

#include <memory>

#include "host/check.h"
#include "host/detector_impl.h"
#include "kernels/buffer_frames.h"

namespace topotag {

/// Detection in frames on a device, inside the detector.
class OpenClDetection {
 public:
  static void Run(Detector* detector, const OpenClFrame& frame, std::vector<Detection>* detections,
                  cl_event* released);

 private:
  static opencl::BufferFrames* Frames(Detector::Impl* impl, cl_command_queue queue);
};

opencl::BufferFrames* OpenClDetection::Frames(Detector::Impl* impl, cl_command_queue queue) {
  cl_context context = nullptr;
  cl_device_id device = nullptr;
  TOPOTAG_CL(clGetCommandQueueInfo, queue, CL_QUEUE_CONTEXT, sizeof(context), &context, nullptr);
  TOPOTAG_CL(clGetCommandQueueInfo, queue, CL_QUEUE_DEVICE, sizeof(device), &device, nullptr);
  auto* frames = static_cast<opencl::BufferFrames*>(impl->device_frames.get());
  if (frames != nullptr && frames->Serves(context, device)) return frames;
  auto made = std::make_unique<opencl::BufferFrames>(
      opencl::Describe(device), context, MakeBackend(BackendKind::kSimd, &impl->workers));
  frames = made.get();
  if (impl->source == impl->device_frames.get()) impl->TakeFrom(nullptr);
  impl->device_frames = std::move(made);
  return frames;
}

void OpenClDetection::Run(Detector* detector, const OpenClFrame& frame,
                          std::vector<Detection>* detections, cl_event* released) {
  RequireNotNull(detections, "detections");
  detections->clear();
  if (released != nullptr) *released = nullptr;
  Detector::Impl* const impl = &detector->impl();
  const DetectorUse use(&impl->one_thread);
  const BackendKind kind = impl->options.backend;
  if (kind != BackendKind::kAuto && kind != BackendKind::kOpenCl) {
    FailArgument(std::string("a frame on an OpenCL device needs backend auto or opencl, not ") +
                 Name(kind));
  }
  if (impl->options.pre_blur) FailArgument("a frame on an OpenCL device cannot be smoothed first");
  if (!impl->pending.empty()) FailArgument("detect: submitted frames have not been collected");
  if (frame.queue == nullptr || frame.buffer == nullptr) {
    FailArgument("the frame has no queue or no buffer");
  }
  // Any address will do to have the sizes checked as those of other frames are.
  const uint8_t pixel = 0;
  const Rect area =
      impl->Area({&pixel, frame.width, frame.height, static_cast<ptrdiff_t>(frame.stride)});
  opencl::BufferFrames* const frames = Frames(impl, frame.queue);
  frames->Set(frame);
  impl->TakeFrom(frames);
  frames->Submit(area, impl->threshold_params);
  impl->Detect(frames->shadow(), area, detections);
  if (released == nullptr) return;
  const cl_event last = frames->released().get();
  try {
    TOPOTAG_CL(clRetainEvent, last);
  } catch (...) {
    detections->clear();
    throw;
  }
  *released = last;
}

void detect(Detector& detector, const OpenClFrame& frame, std::vector<Detection>* detections,
            cl_event* released) {
  OpenClDetection::Run(&detector, frame, detections, released);
}

}  // namespace topotag
