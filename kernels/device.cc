#include "kernels/device.h"

#include <algorithm>
#include <mutex>

#include "kernels/check.h"
#include "topotag/error.h"

namespace topotag::opencl {
namespace {

// What the loader answers where no platform is installed (cl_khr_icd).
constexpr cl_int kPlatformNotFound = -1001;

template <typename Get>
std::string Text(Get get) {
  size_t size = 0;
  get(0, nullptr, &size);
  std::string text(size, '\0');
  get(size, text.data(), nullptr);
  text.resize(std::min(text.find('\0'), text.size()));
  const size_t begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? std::string() : text.substr(begin);
}

std::string DeviceText(cl_device_id id, cl_device_info what) {
  return Text([&](size_t size, char* text, size_t* needed) {
    TOPOTAG_CL(clGetDeviceInfo, id, what, size, text, needed);
  });
}

std::string TypeName(cl_device_type type) {
  if ((type & CL_DEVICE_TYPE_GPU) != 0) return "GPU";
  if ((type & CL_DEVICE_TYPE_CPU) != 0) return "CPU";
  if ((type & CL_DEVICE_TYPE_ACCELERATOR) != 0) return "accelerator";
  return "other";
}

std::vector<cl_platform_id> Platforms() {
  cl_uint count = 0;
  const cl_int code = clGetPlatformIDs(0, nullptr, &count);
  if (code == kPlatformNotFound || (code == CL_SUCCESS && count == 0)) return {};
  TOPOTAG_CL_CODE(clGetPlatformIDs, code);
  std::vector<cl_platform_id> platforms(count);
  TOPOTAG_CL(clGetPlatformIDs, count, platforms.data(), nullptr);
  return platforms;
}

std::vector<cl_device_id> DevicesOf(cl_platform_id platform) {
  cl_uint count = 0;
  const cl_int code = clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count);
  if (code == CL_DEVICE_NOT_FOUND || (code == CL_SUCCESS && count == 0)) return {};
  TOPOTAG_CL_CODE(clGetDeviceIDs, code);
  std::vector<cl_device_id> devices(count);
  TOPOTAG_CL(clGetDeviceIDs, platform, CL_DEVICE_TYPE_ALL, count, devices.data(), nullptr);
  return devices;
}

}  // namespace

Device Describe(cl_device_id id) {
  Device device;
  device.id = id;
  TOPOTAG_CL(clGetDeviceInfo, id, CL_DEVICE_TYPE, sizeof(device.type), &device.type, nullptr);
  cl_uint units = 0;
  TOPOTAG_CL(clGetDeviceInfo, id, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof(units), &units, nullptr);
  cl_platform_id platform = nullptr;
  TOPOTAG_CL(clGetDeviceInfo, id, CL_DEVICE_PLATFORM, sizeof(platform), &platform, nullptr);
  device.info.name = DeviceText(id, CL_DEVICE_NAME);
  device.info.version = DeviceText(id, CL_DEVICE_VERSION);
  device.info.driver = DeviceText(id, CL_DRIVER_VERSION);
  device.info.type = TypeName(device.type);
  device.info.compute_units = static_cast<int>(units);
  device.info.platform = Text([&](size_t size, char* text, size_t* needed) {
    TOPOTAG_CL(clGetPlatformInfo, platform, CL_PLATFORM_NAME, size, text, needed);
  });
  return device;
}

std::vector<Device> AllDevices() {
  // The loader and some drivers set themselves up at the first call, which another thread must not
  // see half done.
  static std::mutex first_call;
  const std::lock_guard<std::mutex> lock(first_call);
  std::vector<Device> all;
  for (const cl_platform_id platform : Platforms()) {
    for (const cl_device_id id : DevicesOf(platform)) {
      all.push_back(Describe(id));
      all.back().info.index = static_cast<int>(all.size()) - 1;
    }
  }
  return all;
}

Device ChooseDevice(std::optional<int> index) {
  const std::vector<Device> all = AllDevices();
  if (all.empty()) {
    throw Error(ErrorCode::kUnavailable,
                "backend 'opencl': this machine has no OpenCL device (no driver is installed)");
  }
  if (!index) {
    const auto gpu = std::find_if(all.begin(), all.end(), [](const Device& device) {
      return (device.type & CL_DEVICE_TYPE_GPU) != 0;
    });
    return gpu == all.end() ? all.front() : *gpu;
  }
  if (*index < 0 || static_cast<size_t>(*index) >= all.size()) {
    throw Error(ErrorCode::kInvalidArgument, "OpenCL device " + std::to_string(*index) +
                                                 " does not exist; there are " +
                                                 std::to_string(all.size()) + ", counted from 0");
  }
  return all[static_cast<size_t>(*index)];
}

}  // namespace topotag::opencl
