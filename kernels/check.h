#ifndef TOPOTAG_KERNELS_CHECK_H_
#define TOPOTAG_KERNELS_CHECK_H_

#include <CL/cl.h>

#include <string>
#include <utility>

namespace topotag::opencl {

/// "CL_OUT_OF_RESOURCES (-5)".
std::string CodeName(cl_int code);

/// @throws Error (kDevice) "OpenCL: CALL failed with CODE at FILE:LINE".
[[noreturn]] void FailCall(const char* call, cl_int code, const char* file, int line);

/// Owns one reference to an OpenCL object.
template <typename T, cl_int (*kRelease)(T)>
class Handle {
 public:
  Handle() = default;
  explicit Handle(T object) : object_(object) {}
  ~Handle() { Reset(); }
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) {
      Reset();
      object_ = std::exchange(other.object_, nullptr);
    }
    return *this;
  }

  T get() const { return object_; }
  void Reset() {
    // A failed release leaves nothing to do.
    if (object_ != nullptr) kRelease(object_);
    object_ = nullptr;
  }
  /// Where a call writes an object that this then owns.
  T* out() {
    Reset();
    return &object_;
  }

 private:
  T object_ = nullptr;
};

using Context = Handle<cl_context, clReleaseContext>;
using Queue = Handle<cl_command_queue, clReleaseCommandQueue>;
using Program = Handle<cl_program, clReleaseProgram>;
using Kernel = Handle<cl_kernel, clReleaseKernel>;
using Memory = Handle<cl_mem, clReleaseMemObject>;
using Event = Handle<cl_event, clReleaseEvent>;

}  // namespace topotag::opencl

/// Calls function(arguments...) of OpenCL that returns its code.
#define TOPOTAG_CL(function, ...)                                                  \
  do {                                                                             \
    const cl_int topotag_cl_code = function(__VA_ARGS__);                          \
    if (topotag_cl_code != CL_SUCCESS) {                                           \
      ::topotag::opencl::FailCall(#function, topotag_cl_code, __FILE__, __LINE__); \
    }                                                                              \
  } while (false)

/// Checks the code that a function of OpenCL, named for the message, has written to `code`.
#define TOPOTAG_CL_CODE(function, code)                                 \
  do {                                                                  \
    if ((code) != CL_SUCCESS) {                                         \
      ::topotag::opencl::FailCall(#function, code, __FILE__, __LINE__); \
    }                                                                   \
  } while (false)

#endif  // TOPOTAG_KERNELS_CHECK_H_
