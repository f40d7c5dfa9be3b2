// Each call of OpenCL fails once, and with it all that follow, as when a device disappears: a clear
// error, and neither this detector's next frame nor the next detector is any the worse.

#include <CL/cl.h>
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "kernels/embedded.h"
#include "tests/frames.h"
#include "tests/opencl_util.h"
#include "tests/temporary_folder.h"
#include "topotag/detector.h"
#include "topotag/opencl.h"

namespace {

constexpr cl_int kCode = CL_DEVICE_NOT_AVAILABLE;

bool is_armed = false;
bool fails_for_good = false;
int before_failure = 0;
int failures = 0;

bool Fails() {
  if (!is_armed) return false;
  const int left = before_failure--;
  if (left > 0 || (left < 0 && !fails_for_good)) return false;
  ++failures;
  return true;
}

template <typename Function>
Function* Real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

// The test's own functions come before those of the OpenCL library. Releases, which the library
// does not check, are left out.
#define TOPOTAG_CODE_CALL(name, parameters, ...)           \
  cl_int name parameters {                                 \
    static auto* const real = Real<decltype(name)>(#name); \
    return Fails() ? kCode : real(__VA_ARGS__);            \
  }
#define TOPOTAG_OBJECT_CALL(type, name, parameters, ...)   \
  type name parameters {                                   \
    static auto* const real = Real<decltype(name)>(#name); \
    if (!Fails()) return real(__VA_ARGS__);                \
    *code = kCode;                                         \
    return nullptr;                                        \
  }

// These are carried out all the same: a device that has gone works on nothing and holds nothing.
#define TOPOTAG_END_CALL(name, parameters, ...)            \
  cl_int name parameters {                                 \
    static auto* const real = Real<decltype(name)>(#name); \
    const cl_int result = real(__VA_ARGS__);               \
    return Fails() ? kCode : result;                       \
  }

using Properties = const cl_context_properties;
using Notify = void(CL_CALLBACK*)(const char*, const void*, size_t, void*);
using Built = void(CL_CALLBACK*)(cl_program, void*);

extern "C" {
TOPOTAG_OBJECT_CALL(cl_context, clCreateContext,
                    (Properties * p, cl_uint n, const cl_device_id* d, Notify f, void* u,
                     cl_int* code),
                    p, n, d, f, u, code)
TOPOTAG_OBJECT_CALL(cl_command_queue, clCreateCommandQueue,
                    (cl_context c, cl_device_id d, cl_command_queue_properties p, cl_int* code), c,
                    d, p, code)
TOPOTAG_OBJECT_CALL(cl_mem, clCreateBuffer,
                    (cl_context c, cl_mem_flags f, size_t n, void* p, cl_int* code), c, f, n, p,
                    code)
TOPOTAG_OBJECT_CALL(cl_program, clCreateProgramWithSource,
                    (cl_context c, cl_uint n, const char** s, const size_t* l, cl_int* code), c, n,
                    s, l, code)
TOPOTAG_OBJECT_CALL(cl_program, clCreateProgramWithBinary,
                    (cl_context c, cl_uint n, const cl_device_id* d, const size_t* l,
                     const unsigned char** b, cl_int* s, cl_int* code),
                    c, n, d, l, b, s, code)
TOPOTAG_OBJECT_CALL(cl_kernel, clCreateKernel, (cl_program p, const char* n, cl_int* code), p, n,
                    code)
TOPOTAG_OBJECT_CALL(void*, clEnqueueMapBuffer,
                    (cl_command_queue q, cl_mem b, cl_bool w, cl_map_flags f, size_t o, size_t n,
                     cl_uint e, const cl_event* l, cl_event* d, cl_int* code),
                    q, b, w, f, o, n, e, l, d, code)
TOPOTAG_CODE_CALL(clBuildProgram,
                  (cl_program p, cl_uint n, const cl_device_id* d, const char* o, Built f, void* u),
                  p, n, d, o, f, u)
TOPOTAG_CODE_CALL(clSetKernelArg, (cl_kernel k, cl_uint i, size_t n, const void* v), k, i, n, v)
TOPOTAG_CODE_CALL(clEnqueueNDRangeKernel,
                  (cl_command_queue q, cl_kernel k, cl_uint n, const size_t* o, const size_t* g,
                   const size_t* l, cl_uint e, const cl_event* w, cl_event* d),
                  q, k, n, o, g, l, e, w, d)
TOPOTAG_CODE_CALL(clEnqueueReadBuffer,
                  (cl_command_queue q, cl_mem b, cl_bool w, size_t o, size_t n, void* p, cl_uint e,
                   const cl_event* l, cl_event* d),
                  q, b, w, o, n, p, e, l, d)
TOPOTAG_CODE_CALL(clEnqueueWriteBuffer,
                  (cl_command_queue q, cl_mem b, cl_bool w, size_t o, size_t n, const void* p,
                   cl_uint e, const cl_event* l, cl_event* d),
                  q, b, w, o, n, p, e, l, d)
TOPOTAG_CODE_CALL(clEnqueueReadBufferRect,
                  (cl_command_queue q, cl_mem b, cl_bool w, const size_t* o, const size_t* h,
                   const size_t* r, size_t a, size_t s, size_t x, size_t y, void* p, cl_uint e,
                   const cl_event* l, cl_event* d),
                  q, b, w, o, h, r, a, s, x, y, p, e, l, d)
TOPOTAG_END_CALL(clEnqueueUnmapMemObject,
                 (cl_command_queue q, cl_mem m, void* p, cl_uint e, const cl_event* l, cl_event* d),
                 q, m, p, e, l, d)
TOPOTAG_CODE_CALL(clEnqueueMarkerWithWaitList,
                  (cl_command_queue q, cl_uint e, const cl_event* l, cl_event* d), q, e, l, d)
TOPOTAG_END_CALL(clWaitForEvents, (cl_uint n, const cl_event* l), n, l)
TOPOTAG_CODE_CALL(clFlush, (cl_command_queue q), q)
TOPOTAG_END_CALL(clFinish, (cl_command_queue q), q)
TOPOTAG_CODE_CALL(clGetEventProfilingInfo,
                  (cl_event e, cl_profiling_info i, size_t n, void* v, size_t* r), e, i, n, v, r)
TOPOTAG_CODE_CALL(clGetDeviceInfo, (cl_device_id d, cl_device_info i, size_t n, void* v, size_t* r),
                  d, i, n, v, r)
TOPOTAG_CODE_CALL(clGetMemObjectInfo, (cl_mem m, cl_mem_info i, size_t n, void* v, size_t* r), m, i,
                  n, v, r)
TOPOTAG_CODE_CALL(clGetCommandQueueInfo,
                  (cl_command_queue q, cl_command_queue_info i, size_t n, void* v, size_t* r), q, i,
                  n, v, r)
TOPOTAG_CODE_CALL(clGetKernelWorkGroupInfo,
                  (cl_kernel k, cl_device_id d, cl_kernel_work_group_info i, size_t n, void* v,
                   size_t* r),
                  k, d, i, n, v, r)
TOPOTAG_CODE_CALL(clRetainEvent, (cl_event e), e)
TOPOTAG_CODE_CALL(clRetainContext, (cl_context c), c)
TOPOTAG_CODE_CALL(clGetPlatformIDs, (cl_uint n, cl_platform_id* p, cl_uint* r), n, p, r)
}

namespace topotag {
namespace {

// Calls work() with what make() makes, each time with another of its calls failing, then with all
// that follow failing too, until it needs no more; check() comes after each. Of `stride` calls, one
// fails.
template <typename Make, typename Work, typename Check>
void FailEachCall(const Make& make, const Work& work, const Check& check, int stride = 1) {
  for (const bool for_good : {false, true}) {
    int index = 0;
    for (bool failed = true; failed; index += stride) {
      auto made = make();
      before_failure = index;
      failures = 0;
      fails_for_good = for_good;
      is_armed = true;
      std::string message;
      try {
        work(made.get());
      } catch (const Error& error) {
        message = error.what();
        EXPECT_EQ(error.code(), ErrorCode::kDevice) << message;
        EXPECT_NE(message.find("CL_DEVICE_NOT_AVAILABLE"), std::string::npos) << message;
      }
      is_armed = false;
      failed = failures > 0;
      check(made.get());
      if (::testing::Test::HasFailure()) {
        ADD_FAILURE() << "after a failure of call " << index << (for_good ? " and on: " : ": ")
                      << message;
        return;
      }
    }
    EXPECT_GT(index, 5);
  }
}

std::string Ids(const std::vector<Detection>& detections) {
  std::string ids;
  for (const Detection& d : detections) {
    ids += d.family.name() + " " + std::to_string(d.id) + " " + std::to_string(d.center.x) + "\n";
  }
  return ids;
}

Options OpenCl() {
  Options options;
  options.backend = BackendKind::kOpenCl;
  options.threads = 1;
  return options;
}

class FaultOpenClTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_NE(expected_, ""); }
  static void ExpectNextDetectorWorks() { EXPECT_NO_THROW(Detector detector(OpenCl())); }

  // One for all tests: without it, each first build would take a second.
  static inline test::TemporaryFolder folder_;
  ScopedVariable cache_{"TOPOTAG_CACHE_DIR", folder_.path().string()};
  const GuardedImage frame_ = MakeFrame({320, 240, 1, FrameKind::kMarkers, 5});
  const GuardedImage other_ = MakeFrame({200, 90, 1, FrameKind::kMarkers, 6});
  const std::string expected_ = Ids(Detector(Options()).detect(frame_.view()));
};

TEST_F(FaultOpenClTest, Construction) {
  ExpectNextDetectorWorks();
  FailEachCall([] { return std::make_unique<int>(); }, [](int*) { Detector detector(OpenCl()); },
               [](int*) {});
  ExpectNextDetectorWorks();
}

TEST_F(FaultOpenClTest, Frames) {
  FailEachCall(
      [] { return std::make_unique<Detector>(OpenCl()); },
      [&](Detector* detector) { detector->detect(frame_.view()); },
      [&](Detector* detector) { EXPECT_EQ(Ids(detector->detect(frame_.view())), expected_); });
}

TEST_F(FaultOpenClTest, LargerFrames) {
  const auto make = [&] {
    auto detector = std::make_unique<Detector>(OpenCl());
    detector->detect(other_.view());
    return detector;
  };
  FailEachCall(
      make, [&](Detector* detector) { detector->detect(frame_.view()); },
      [&](Detector* detector) {
        EXPECT_NO_THROW(detector->detect(other_.view()));
        EXPECT_EQ(Ids(detector->detect(frame_.view())), expected_);
      });
}

TEST_F(FaultOpenClTest, SubmittedFrames) {
  struct State {
    Detector detector{OpenCl()};
    size_t submitted = 0, collected = 0;
  };
  const ImageView frames[] = {frame_.view(), other_.view()};
  const std::string expected[] = {expected_, Ids(Detector(Options()).detect(other_.view()))};
  FailEachCall([] { return std::make_unique<State>(); },
               [&](State* state) {
                 for (const ImageView& frame : frames) {
                   state->detector.submit(frame);
                   ++state->submitted;
                 }
                 std::vector<Detection> detections;
                 for (const std::string& ids : expected) {
                   ++state->collected;
                   state->detector.collect(&detections);
                   EXPECT_EQ(Ids(detections), ids);
                 }
               },
               [&](State* state) {
                 // What is left of them.
                 std::vector<Detection> detections;
                 while (state->collected < state->submitted) {
                   EXPECT_TRUE(state->detector.collect(&detections));
                   EXPECT_EQ(Ids(detections), expected[state->collected++]);
                 }
                 EXPECT_FALSE(state->detector.collect(&detections));
                 EXPECT_EQ(Ids(state->detector.detect(frame_.view())), expected_);
               });
}

// The staged transfers of a GPU, which no detector takes on a CPU.
TEST_F(FaultOpenClTest, StagedTransfers) {
  const Reference expected(frame_.view(), {});
  const opencl::Device device = opencl::ChooseDevice({});
  FailEachCall(
      [&] {
        return std::make_unique<opencl::Binarizer>(device, nullptr, opencl::Transfer::kStaged);
      },
      [&](opencl::Binarizer* binarizer) {
        BitImage bits;
        binarizer->Submit(frame_.view(), {});
        binarizer->Collect(&bits);
      },
      [&](opencl::Binarizer* binarizer) {
        BitImage bits;
        while (binarizer->submitted() > 0) binarizer->Collect(&bits);
        binarizer->Submit(frame_.view(), {});
        EXPECT_EQ(CollectDifference(expected, binarizer), "");
      });
}

TEST_F(FaultOpenClTest, FramesOnTheDevice) {
  const opencl::Device device = opencl::ChooseDevice({});
  cl_int code = CL_SUCCESS;
  const opencl::Context context(clCreateContext(nullptr, 1, &device.id, nullptr, nullptr, &code));
  const opencl::Queue queue(clCreateCommandQueue(context.get(), device.id, 0, &code));
  const ImageView view = frame_.view();
  std::vector<uint8_t> pixels;
  for (int y = 0; y < view.height; ++y) {
    pixels.insert(pixels.end(), view.row(y), view.row(y) + view.width);
  }
  const opencl::Memory buffer(
      clCreateBuffer(context.get(), CL_MEM_COPY_HOST_PTR, pixels.size(), pixels.data(), &code));
  ASSERT_EQ(code, CL_SUCCESS);
  const OpenClFrame frame{queue.get(), buffer.get(), 0,
                          view.width,  view.height,  static_cast<size_t>(view.width)};
  std::vector<Detection> detections;
  bool is_done = false;
  const auto detect = [&](Detector* detector) {
    is_done = false;
    cl_event released = nullptr;
    topotag::detect(*detector, frame, &detections, &released);
    is_done = true;
    clReleaseEvent(released);
    return Ids(detections);
  };
  FailEachCall([] { return std::make_unique<Detector>(OpenCl()); }, detect,
               [&](Detector* detector) {
                 EXPECT_TRUE(is_done || detections.empty());
                 EXPECT_EQ(detect(detector), expected_);
                 EXPECT_EQ(Ids(detector->detect(frame_.view())), expected_);
               },
               /*stride=*/5);
}

TEST_F(FaultOpenClTest, KernelsThatDoNotBuild) {
  const test::TemporaryFolder sources;
  for (size_t i = 0; i < opencl::kKernelFileCount; ++i) {
    const opencl::KernelFile& file = opencl::kKernelFiles[i];
    std::ofstream out(sources.path() / file.name, std::ios::binary);
    out.write(file.text, static_cast<std::streamsize>(file.size));
    if (i == 0) out << "\nint broken = no_such_name;\n";
  }
  {
    const ScopedVariable folder("TOPOTAG_KERNEL_DIR", sources.path().string());
    ExpectError(ErrorCode::kDevice, {"do not build", "no_such_name"},
                [] { Detector detector(OpenCl()); });
  }
  ExpectNextDetectorWorks();
}

}  // namespace
}  // namespace topotag
