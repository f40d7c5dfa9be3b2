#ifndef TOPOTAG_DEVICE_H_
#define TOPOTAG_DEVICE_H_

#include <string>
#include <vector>

namespace topotag {

/// A device that the opencl backend can be asked to run on.
struct DeviceInfo {
  int index = 0;  ///< what Options::device takes
  std::string name;
  std::string platform;
  std::string version;  ///< of OpenCL, as the device states it
  std::string driver;   ///< version of its driver
  std::string type;     ///< "CPU", "GPU", "accelerator", "other"
  int compute_units = 0;
};

/// The OpenCL devices of this machine, platform by platform; empty where there are none, or where
/// this build has no opencl backend.
/// @throws Error (kDevice) where a platform does not answer.
std::vector<DeviceInfo> ListDevices();

}  // namespace topotag

#endif  // TOPOTAG_DEVICE_H_
