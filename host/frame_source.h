#ifndef TOPOTAG_HOST_FRAME_SOURCE_H_
#define TOPOTAG_HOST_FRAME_SOURCE_H_

#include <vector>

#include "host/backend.h"
#include "topotag/geometry.h"
#include "topotag/image.h"

namespace topotag {

/// Where a detector's frames come from when they are not in host memory: a backend that knows them,
/// and a copy of them in host memory, of which only the parts that were asked for are valid.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual Backend* backend() = 0;
  /// The copy of the current frame. It stays in place until the next frame.
  virtual ImageView shadow() const = 0;
  /// Makes parts of the copy valid. They lie within the frame and may overlap.
  virtual void Fetch(const std::vector<Rect>& parts) = 0;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_FRAME_SOURCE_H_
