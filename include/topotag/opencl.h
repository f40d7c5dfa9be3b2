#ifndef TOPOTAG_OPENCL_H_
#define TOPOTAG_OPENCL_H_

// Frames that are on an OpenCL device already. Only in builds with the opencl backend.

#include <CL/cl.h>

#include <cstddef>
#include <vector>

#include "topotag/detection.h"
#include "topotag/detector.h"

namespace topotag {

/// A grayscale frame in a buffer; row y begins at byte offset + y * stride.
struct OpenClFrame {
  cl_command_queue queue = nullptr;  ///< says on which context and device to work
  cl_mem buffer = nullptr;
  size_t offset = 0;
  int width = 0;      ///< pixels, 1 .. kMaxImageSide
  int height = 0;     ///< pixels, 1 .. kMaxImageSide
  size_t stride = 0;  ///< bytes from one row to the next, >= width
  /// After which the frame is complete; null: after all that the queue holds already.
  cl_event wait_for = nullptr;
};

/// Detects the markers in a frame on a device, as Detector::detect does in a frame in host memory.
///
/// The threshold map and the bits are computed there, on a queue of the detector's own; only the
/// bits and the pixels around candidates are transferred. The first frame of a context builds the
/// kernels for it; the detector keeps the context until it sees another one.
/// @param detector  of backend auto or opencl; what ran is in detector.backend() afterwards
/// @param released  if not null, an event of the frame's context after which nothing reads the
/// frame
///                  any more: it is complete when this returns. The caller releases it.
/// @throws Error as Detector::detect; also kInvalidArgument: a frame that does not fit its buffer,
///         a detector of another backend.
void detect(Detector& detector, const OpenClFrame& frame, std::vector<Detection>* detections,
            cl_event* released = nullptr);

}  // namespace topotag

#endif  // TOPOTAG_OPENCL_H_
