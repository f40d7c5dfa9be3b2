// Frames that are on a device already: on the user's context and queue.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "kernels/check.h"
#include "tests/frames.h"
#include "tests/opencl_util.h"
#include "tests/scene_util.h"
#include "topotag/opencl.h"

namespace topotag {
namespace {

using opencl::Event;
using opencl::Memory;

// A user's context, queue and frames.
class OpenClFrameTest : public ::testing::Test {
 protected:
  OpenClFrameTest() {
    cl_int code = CL_SUCCESS;
    context_ = opencl::Context(clCreateContext(nullptr, 1, &device_.id, nullptr, nullptr, &code));
    TOPOTAG_CL_CODE(clCreateContext, code);
    queue_ = opencl::Queue(clCreateCommandQueue(context_.get(), device_.id,
                                                CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &code));
    if (code != CL_SUCCESS) {
      queue_ = opencl::Queue(clCreateCommandQueue(context_.get(), device_.id, 0, &code));
    }
    TOPOTAG_CL_CODE(clCreateCommandQueue, code);
  }

  // Queues the transfer of an image into a new buffer, after a first part that is not the frame's.
  OpenClFrame Upload(const ImageView& image, size_t offset, size_t padding) {
    OpenClFrame frame;
    frame.queue = queue_.get();
    frame.offset = offset;
    frame.width = image.width;
    frame.height = image.height;
    frame.stride = static_cast<size_t>(image.width) + padding;
    bytes_.assign(offset + frame.stride * static_cast<size_t>(image.height), 0x55);
    for (int y = 0; y < image.height; ++y) {
      std::copy_n(
          image.row(y), image.width,
          bytes_.begin() + static_cast<ptrdiff_t>(offset + static_cast<size_t>(y) * frame.stride));
    }
    cl_int code = CL_SUCCESS;
    buffer_ =
        Memory(clCreateBuffer(context_.get(), CL_MEM_READ_ONLY, bytes_.size(), nullptr, &code));
    TOPOTAG_CL_CODE(clCreateBuffer, code);
    frame.buffer = buffer_.get();
    TOPOTAG_CL(clEnqueueWriteBuffer, queue_.get(), buffer_.get(), CL_FALSE, 0, bytes_.size(),
               bytes_.data(), 0, nullptr, written_.out());
    return frame;
  }

  static void ExpectSame(const std::vector<Detection>& expected,
                         const std::vector<Detection>& actual) {
    ASSERT_EQ(expected.size(), actual.size());
    for (size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(expected[i].id, actual[i].id);
      ASSERT_EQ(expected[i].vertices.size(), actual[i].vertices.size());
      for (int k = 0; k < expected[i].vertices.size(); ++k) {
        EXPECT_EQ(expected[i].vertices[k].x, actual[i].vertices[k].x);
        EXPECT_EQ(expected[i].vertices[k].y, actual[i].vertices[k].y);
      }
    }
  }

  opencl::Device device_ = opencl::ChooseDevice({});
  opencl::Context context_;
  opencl::Queue queue_;
  Memory buffer_;
  Event written_;
  std::vector<uint8_t> bytes_;
};

TEST_F(OpenClFrameTest, AreAsThoseInHostMemory) {
  Detector host, detector;
  std::vector<Detection> detections;
  size_t found = 0;
  for (uint64_t seed = 0; seed < 60; ++seed) {
    const int width = 640 - static_cast<int>(seed % 7) * 31;
    const GuardedImage image = MakeFrame({width, 480, 1, FrameKind::kMarkers, seed});
    OpenClFrame frame = Upload(image.view(), seed % 3 * 1001, seed % 5 * 7);
    // Otherwise the detector waits for the queue.
    if (seed % 2 == 0) frame.wait_for = written_.get();
    Event released;
    detect(detector, frame, &detections, released.out());
    EXPECT_EQ(detector.backend(), "opencl/" + device_.info.name);
    cl_int status = CL_QUEUED;
    TOPOTAG_CL(clGetEventInfo, released.get(), CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof(status),
               &status, nullptr);
    EXPECT_EQ(status, CL_COMPLETE);
    ExpectSame(host.detect(image.view()), detections);
    if (HasFatalFailure()) return;
    found += detections.size();
  }
  EXPECT_GT(found, 10U);
}

// The complement is searched on the processor: the whole area is transferred.
TEST_F(OpenClFrameTest, InvertedMarkersToo) {
  Options options;
  options.inverted = true;
  Detector host(options), detector(options);
  Image image(640, 480);
  size_t inverted = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const GuardedImage frame = MakeFrame({640, 480, 1, FrameKind::kMarkers, seed});
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        const int level = frame.view().row(y)[x];
        image.row(y)[x] = static_cast<uint8_t>(seed % 3 == 0 ? level : 255 - level);
      }
    }
    std::vector<Detection> detections;
    detect(detector, Upload(image.view(), 0, 0), &detections);
    const std::vector<Detection> expected = host.detect(image.view());
    ExpectSame(expected, detections);
    for (size_t i = 0; i < detections.size(); ++i) {
      EXPECT_EQ(detections[i].inverted, expected[i].inverted);
      inverted += detections[i].inverted;
    }
  }
  EXPECT_GT(inverted, 2u);
}

// Around large and steep markers too, everything that decoding and refining read is transferred:
// what is not comes from other frames.
TEST_F(OpenClFrameTest, SurroundingsOfMarkersAreTransferred) {
  Options options;
  options.families = {Family(3), Family(4), Family(5), Family(8)};
  Detector host(options), detector(options);
  test::Random random(5);
  Scene scene;
  scene.camera = test::PinholeCamera(640, 480, 600);
  std::vector<Detection> detections;
  size_t found = 0;
  for (uint64_t seed = 0; seed < 120; ++seed) {
    SceneMarker marker;
    marker.design.family = options.families[seed % 4];
    marker.design.id = random.Below(marker.design.family.size());
    const double pitch = random.Uniform(7, seed % 4 == 3 ? 40 : 90);
    const double z =
        test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size, pitch);
    marker.t = {random.Uniform(-0.2, 0.2) * z, random.Uniform(-0.15, 0.15) * z, z};
    marker.R = random.Tilted(random.Uniform(0, 65) * test::kDegree);
    scene.markers = {marker};
    scene.seed = seed;
    const Image image = RenderScene(scene);
    detect(detector, Upload(image.view(), 0, 0), &detections);
    ExpectSame(host.detect(image.view()), detections);
    if (HasFatalFailure()) return;
    found += detections.size();
  }
  EXPECT_GT(found, 80U);
}

// Matched filters read what no candidate of the bit image made the transfers bring.
TEST_F(OpenClFrameTest, FarMarkers) {
  Options options;
  options.far = true;
  Detector host(options), detector(options);
  test::Random random(8);
  Scene scene;
  scene.camera = test::PinholeCamera(640, 480, 695);
  std::vector<Detection> detections;
  size_t far = 0;
  for (uint64_t seed = 0; seed < 30; ++seed) {
    const GuardedImage background = MakeFrame({640, 480, 0, FrameKind::kRectangles, seed});
    scene.background_image = seed % 2 == 0 ? ImageView{} : background.view();
    scene.markers.assign(3, {});
    for (size_t i = 0; i < 3; ++i) {
      SceneMarker& marker = scene.markers[i];
      marker.design.family = Family(3 + static_cast<int>(seed % 3));
      marker.design.id = random.Below(marker.design.family.size());
      const double z = random.Uniform(0.4, 2);
      marker.t = {(0.25 * static_cast<double>(i) - 0.25) * z, random.Uniform(-0.2, 0.2) * z, z};
      marker.R = random.Tilted(random.Uniform(0, 45) * test::kDegree);
    }
    scene.seed = seed;
    const Image image = RenderScene(scene);
    detect(detector, Upload(image.view(), seed % 3 * 77, seed % 4 * 5), &detections);
    ExpectSame(host.detect(image.view()), detections);
    if (HasFatalFailure()) return;
    for (const Detection& detection : detections) far += detection.margin.has_value();
  }
  EXPECT_GT(far, 20U);
}

TEST_F(OpenClFrameTest, TheDetectorTakesHostFramesInBetween) {
  Detector detector;
  const std::string host = detector.backend();
  const GuardedImage image = MakeFrame({320, 240, 0, FrameKind::kMarkers, 1});
  const std::vector<Detection> expected = detector.detect(image.view());
  std::vector<Detection> detections;
  detect(detector, Upload(image.view(), 0, 0), &detections);
  ExpectSame(expected, detections);
  EXPECT_NE(detector.backend(), host);
  ExpectSame(expected, detector.detect(image.view()));
  EXPECT_EQ(detector.backend(), host);
}

TEST_F(OpenClFrameTest, RegionOfInterest) {
  Options options;
  options.roi = Rect{33, 17, 251, 199};
  Detector host(options), detector(options);
  std::vector<Detection> detections;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const GuardedImage image = MakeFrame({320, 240, 0, FrameKind::kMarkers, seed});
    detect(detector, Upload(image.view(), 5, 3), &detections);
    ExpectSame(host.detect(image.view()), detections);
    if (HasFatalFailure()) return;
  }
}

// Of markers that the region cuts, more is read than the region.
TEST_F(OpenClFrameTest, RegionsThatCutMarkers) {
  Options options;
  options.hidden_nodes = 8;
  options.far = true;
  Random random(3);
  std::vector<Detection> detections;
  for (uint64_t seed = 0; seed < 60; ++seed) {
    const GuardedImage image = MakeFrame({320, 240, 0, FrameKind::kMarkers, seed % 6});
    const int x = random.Below(160), y = random.Below(120);
    options.roi = Rect{x, y, random.Between(60, 320 - x), random.Between(60, 240 - y)};
    Detector detector(options);
    detect(detector, Upload(image.view(), 0, 0), &detections);
    ExpectSame(Detector(options).detect(image.view()), detections);
    if (HasFatalFailure()) return;
  }
}

TEST_F(OpenClFrameTest, OnlyBuffersOfTheQueuesContext) {
  Detector detector;
  const GuardedImage image = MakeFrame({320, 240, 0, FrameKind::kMarkers, 1});
  const OpenClFrame good = Upload(image.view(), 0, 0);
  std::vector<Detection> detections;
  const auto refused = [&](const OpenClFrame& frame, ErrorCode error, const char* part) {
    ExpectError(error, {part}, [&] { detect(detector, frame, &detections); });
  };
  cl_int code = CL_SUCCESS;
  const opencl::Context other(clCreateContext(nullptr, 1, &device_.id, nullptr, nullptr, &code));
  const Memory foreign(clCreateBuffer(other.get(), 0, 320 * 240, nullptr, &code));
  OpenClFrame frame = good;
  frame.buffer = foreign.get();
  refused(frame, ErrorCode::kInvalidArgument, "buffer is of another context");
  frame = good;
  const Event unrelated(clCreateUserEvent(other.get(), &code));
  frame.wait_for = unrelated.get();
  refused(frame, ErrorCode::kInvalidArgument, "event is of another context");
  // PoCL waits without end for what has failed already.
  const Event failed(clCreateUserEvent(context_.get(), &code));
  TOPOTAG_CL(clSetUserEventStatus, failed.get(), -5);
  frame.wait_for = failed.get();
  refused(frame, ErrorCode::kDevice, "has failed with -5");
  cl_image_format format{CL_R, CL_UNORM_INT8};
  cl_image_desc size{};
  size.image_type = CL_MEM_OBJECT_IMAGE2D;
  size.image_width = 320;
  size.image_height = 240;
  const Memory picture(clCreateImage(context_.get(), 0, &format, &size, nullptr, &code));
  if (code == CL_SUCCESS) {
    frame = good;
    frame.buffer = picture.get();
    refused(frame, ErrorCode::kInvalidArgument, "not a buffer");
  }
  detect(detector, good, &detections);
  ExpectSame(Detector().detect(image.view()), detections);
}

TEST_F(OpenClFrameTest, WrongFramesAreRefused) {
  Detector detector;
  const GuardedImage image = MakeFrame({320, 240, 0, FrameKind::kMarkers, 1});
  const OpenClFrame good = Upload(image.view(), 0, 0);
  std::vector<Detection> detections;
  const auto refused = [&](const OpenClFrame& frame, const char* part) {
    ExpectError(ErrorCode::kInvalidArgument, {part}, [&] { detect(detector, frame, &detections); });
  };
  OpenClFrame frame = good;
  frame.offset = 1;
  refused(frame, "beyond its buffer");
  frame = good;
  frame.offset = ~size_t{0};
  refused(frame, "beyond its buffer");
  frame = good;
  frame.stride += 1;
  refused(frame, "beyond its buffer");
  frame = good;
  frame.stride -= 1;
  refused(frame, "stride");
  frame = good;
  frame.width = 0;
  refused(frame, "0x240");
  frame = good;
  frame.queue = nullptr;
  refused(frame, "no queue");
  frame = good;
  frame.buffer = nullptr;
  refused(frame, "no buffer");
  Options options;
  options.backend = BackendKind::kSimd;
  Detector simd(options);
  ExpectError(ErrorCode::kInvalidArgument, {"simd"}, [&] { detect(simd, good, &detections); });
  detect(detector, good, &detections);
}

}  // namespace
}  // namespace topotag
