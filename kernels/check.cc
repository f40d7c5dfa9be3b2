#include "kernels/check.h"

#include <cstring>

#include "topotag/error.h"

namespace topotag::opencl {
namespace {

struct NamedCode {
  cl_int code;
  const char* name;
};

#define TOPOTAG_NAMED(code) \
  { code, #code }
constexpr NamedCode kCodes[] = {
    TOPOTAG_NAMED(CL_DEVICE_NOT_FOUND),
    TOPOTAG_NAMED(CL_DEVICE_NOT_AVAILABLE),
    TOPOTAG_NAMED(CL_COMPILER_NOT_AVAILABLE),
    TOPOTAG_NAMED(CL_MEM_OBJECT_ALLOCATION_FAILURE),
    TOPOTAG_NAMED(CL_OUT_OF_RESOURCES),
    TOPOTAG_NAMED(CL_OUT_OF_HOST_MEMORY),
    TOPOTAG_NAMED(CL_PROFILING_INFO_NOT_AVAILABLE),
    TOPOTAG_NAMED(CL_MEM_COPY_OVERLAP),
    TOPOTAG_NAMED(CL_BUILD_PROGRAM_FAILURE),
    TOPOTAG_NAMED(CL_MAP_FAILURE),
    TOPOTAG_NAMED(CL_MISALIGNED_SUB_BUFFER_OFFSET),
    TOPOTAG_NAMED(CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST),
    TOPOTAG_NAMED(CL_INVALID_VALUE),
    TOPOTAG_NAMED(CL_INVALID_PLATFORM),
    TOPOTAG_NAMED(CL_INVALID_DEVICE),
    TOPOTAG_NAMED(CL_INVALID_CONTEXT),
    TOPOTAG_NAMED(CL_INVALID_QUEUE_PROPERTIES),
    TOPOTAG_NAMED(CL_INVALID_COMMAND_QUEUE),
    TOPOTAG_NAMED(CL_INVALID_HOST_PTR),
    TOPOTAG_NAMED(CL_INVALID_MEM_OBJECT),
    TOPOTAG_NAMED(CL_INVALID_BINARY),
    TOPOTAG_NAMED(CL_INVALID_BUILD_OPTIONS),
    TOPOTAG_NAMED(CL_INVALID_PROGRAM),
    TOPOTAG_NAMED(CL_INVALID_PROGRAM_EXECUTABLE),
    TOPOTAG_NAMED(CL_INVALID_KERNEL_NAME),
    TOPOTAG_NAMED(CL_INVALID_KERNEL_DEFINITION),
    TOPOTAG_NAMED(CL_INVALID_KERNEL),
    TOPOTAG_NAMED(CL_INVALID_ARG_INDEX),
    TOPOTAG_NAMED(CL_INVALID_ARG_VALUE),
    TOPOTAG_NAMED(CL_INVALID_ARG_SIZE),
    TOPOTAG_NAMED(CL_INVALID_KERNEL_ARGS),
    TOPOTAG_NAMED(CL_INVALID_WORK_DIMENSION),
    TOPOTAG_NAMED(CL_INVALID_WORK_GROUP_SIZE),
    TOPOTAG_NAMED(CL_INVALID_WORK_ITEM_SIZE),
    TOPOTAG_NAMED(CL_INVALID_GLOBAL_OFFSET),
    TOPOTAG_NAMED(CL_INVALID_EVENT_WAIT_LIST),
    TOPOTAG_NAMED(CL_INVALID_EVENT),
    TOPOTAG_NAMED(CL_INVALID_OPERATION),
    TOPOTAG_NAMED(CL_INVALID_BUFFER_SIZE),
    TOPOTAG_NAMED(CL_INVALID_GLOBAL_WORK_SIZE),
};
#undef TOPOTAG_NAMED

}  // namespace

std::string CodeName(cl_int code) {
  const std::string number = std::to_string(code);
  for (const NamedCode& known : kCodes) {
    if (known.code == code) return std::string(known.name) + " (" + number + ")";
  }
  return "code " + number;
}

void FailCall(const char* call, cl_int code, const char* file, int line) {
  const char* slash = std::strrchr(file, '/');
  throw Error(ErrorCode::kDevice,
              std::string("OpenCL: ") + call + " failed with " + CodeName(code) + " at " +
                  (slash == nullptr ? file : slash + 1) + ":" + std::to_string(line));
}

}  // namespace topotag::opencl
