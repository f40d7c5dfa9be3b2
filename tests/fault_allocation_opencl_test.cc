// Every allocation fails while a frame on an OpenCL device is searched: the next frame there is
// right, and so is the next one in host memory.

#include <CL/cl.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/detection_text.h"
#include "tests/failing_allocations.h"
#include "tests/frames.h"
#include "tests/opencl_util.h"
#include "topotag/detector.h"
#include "topotag/opencl.h"

namespace topotag {
namespace {

/// A frame in host memory and in a buffer.
struct TestFrame {
  TestFrame(const FrameCase& frame, const opencl::Queue& queue, cl_context context)
      : host(MakeFrame(frame)) {
    const ImageView view = host.view();
    std::vector<uint8_t> pixels;
    for (int y = 0; y < view.height; ++y) {
      pixels.insert(pixels.end(), view.row(y), view.row(y) + view.width);
    }
    cl_int code = CL_SUCCESS;
    buffer = opencl::Memory(
        clCreateBuffer(context, CL_MEM_COPY_HOST_PTR, pixels.size(), pixels.data(), &code));
    TOPOTAG_CL_CODE(clCreateBuffer, code);
    device = {queue.get(), buffer.get(), 0,
              view.width,  view.height,  static_cast<size_t>(view.width)};
    expected = DetectionText(Detector().detect(view)).str();
  }

  GuardedImage host;
  opencl::Memory buffer;
  OpenClFrame device;
  std::string expected;
};

TEST(FaultAllocationOpenClTest, FramesOnTheDevice) {
  const opencl::Device device = opencl::ChooseDevice({});
  cl_int code = CL_SUCCESS;
  const opencl::Context context(clCreateContext(nullptr, 1, &device.id, nullptr, nullptr, &code));
  const opencl::Queue queue(clCreateCommandQueue(context.get(), device.id, 0, &code));
  ASSERT_EQ(code, CL_SUCCESS);
  const TestFrame tiny({16, 16, 1, FrameKind::kMarkers, 1}, queue, context.get());
  const TestFrame large({320, 240, 1, FrameKind::kMarkers, 5}, queue, context.get());
  const TestFrame small({200, 90, 1, FrameKind::kMarkers, 6}, queue, context.get());
  EXPECT_NE(large.expected, "");
  EXPECT_NE(large.expected, small.expected);
  const auto search = [](Detector* detector, const TestFrame& frame) {
    std::vector<Detection> detections;
    detect(*detector, frame.device, &detections);
    return DetectionText(detections).str();
  };
  Options options;
  options.backend = BackendKind::kOpenCl;
  options.threads = 1;
  test::FailEachAllocation(
      [&] {
        Detector detector(options);
        search(&detector, tiny);  // the kernels of this context
        return detector;
      },
      [&](Detector* detector) { EXPECT_EQ(search(detector, large), large.expected); },
      [&](Detector* detector) {
        EXPECT_EQ(search(detector, small), small.expected);
        EXPECT_EQ(DetectionText(detector->detect(small.host.view())).str(), small.expected);
        EXPECT_EQ(search(detector, large), large.expected);
      });
}

}  // namespace
}  // namespace topotag
