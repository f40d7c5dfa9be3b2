#ifndef TOPOTAG_KERNELS_PROGRAM_H_
#define TOPOTAG_KERNELS_PROGRAM_H_

#include <string>

#include "kernels/check.h"
#include "kernels/device.h"

namespace topotag::opencl {

/// The kernels, built for one device of a context.
///
/// The sources are those embedded in the library, or files of the same names in the folder that
/// the environment variable TOPOTAG_KERNEL_DIR names. What the driver makes of them is kept in the
/// folder TOPOTAG_CACHE_DIR, else $XDG_CACHE_HOME/topotag, else ~/.cache/topotag, under a name that
/// depends on the device, its driver, the sources and the options. A folder or a file that cannot
/// be used is as none, never an error. Any number of processes may build at the same time.
/// @throws Error (kDevice: with the build log; kFile: a source in TOPOTAG_KERNEL_DIR)
Program BuildProgram(cl_context context, const Device& device);

/// The cache's file for this device; empty where there is no folder for it.
/// @throws Error (kFile: a source in TOPOTAG_KERNEL_DIR)
std::string CacheFile(const Device& device);

}  // namespace topotag::opencl

#endif  // TOPOTAG_KERNELS_PROGRAM_H_
