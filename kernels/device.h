#ifndef TOPOTAG_KERNELS_DEVICE_H_
#define TOPOTAG_KERNELS_DEVICE_H_

#include <CL/cl.h>

#include <optional>
#include <string>
#include <vector>

#include "topotag/device.h"

namespace topotag::opencl {

struct Device {
  cl_device_id id = nullptr;
  cl_device_type type = 0;
  DeviceInfo info;
};

/// @throws Error (kDevice)
Device Describe(cl_device_id id);

/// All devices of all platforms, in the order of the platforms.
/// @throws Error (kDevice)
std::vector<Device> AllDevices();

/// The device with this index; without one, the first GPU, else the first device.
/// @throws Error (kUnavailable: there is no device at all; kInvalidArgument: not this one)
Device ChooseDevice(std::optional<int> index);

}  // namespace topotag::opencl

#endif  // TOPOTAG_KERNELS_DEVICE_H_
