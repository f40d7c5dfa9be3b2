#ifndef TOPOTAG_KERNELS_EMBEDDED_H_
#define TOPOTAG_KERNELS_EMBEDDED_H_

#include <cstddef>

namespace topotag::opencl {

/// One .cl file as it was when the library was built; written by cmake/EmbedKernels.cmake.
struct KernelFile {
  const char* name;
  const char* text;  ///< not terminated
  size_t size;
};

/// In the order in which they are compiled.
extern const KernelFile* const kKernelFiles;
extern const size_t kKernelFileCount;

}  // namespace topotag::opencl

#endif  // TOPOTAG_KERNELS_EMBEDDED_H_
