#ifndef TOPOTAG_HOST_SUPPORT_H_
#define TOPOTAG_HOST_SUPPORT_H_

#include <algorithm>
#include <cmath>

#include "host/centroid.h"
#include "host/local_map.h"
#include "topotag/image.h"

namespace topotag {

/// Dark shapes where they are expected in the image, as many as there are, in arrays of their
/// parts. Single precision is enough beside a patch's own fixed point.
struct Supports {
  float half_x[kMaxPoints], half_y[kMaxPoints];  ///< of the shape's sides, units
  float xu[kMaxPoints], xv[kMaxPoints], yu[kMaxPoints],
      yv[kMaxPoints];                              ///< Jacobian, pixels / unit
  float white[kMaxPoints];                         ///< grey level of the gaps around it
  float white_u[kMaxPoints], white_v[kMaxPoints];  ///< its change per unit
};

/// By how much a support is larger than its shape on all sides: delta (host/vertices.h), units.
/// @param area    of a square unit, pixels
/// @param half_y  of the shape's sides, units
inline float SupportGrowth(float area, float half_y) {
  constexpr float kMinDelta = 2;     // pixels
  constexpr float kMaxDelta = 0.5F;  // half the gap, units
  return std::min(std::max(kMinDelta / std::sqrt(area), half_y / 5), kMaxDelta);
}

/// The patches for the weighted centroids of the darkness 1 - grey / white over the supports:
/// relative to the shaded white, so that uneven light does not move them. A support is the shape
/// grown by delta (host/vertices.h), a parallelogram whose edge is smoothed over one pixel. One
/// with nothing to measure gets a patch without pixels.
/// @param x, y  centres, pixels
void MakePatches(const ImageView& image, const Supports& supports, const double* x, const double* y,
                 int count, DarknessPatch* patches);

}  // namespace topotag

#endif  // TOPOTAG_HOST_SUPPORT_H_
