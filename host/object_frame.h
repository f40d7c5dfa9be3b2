#ifndef TOPOTAG_HOST_OBJECT_FRAME_H_
#define TOPOTAG_HOST_OBJECT_FRAME_H_

#include <vector>

#include "host/rigid_transform.h"
#include "topotag/object.h"

namespace topotag {

/// The motion after which the corners of the markers of `object` lie as near to those of `target`,
/// the same markers, as can be, in the mean of squares.
RigidTransform FitFrame(const Object& object, const Object& target);

/// Covariance of the poses (w, dt) of all markers, square, of side 6 times their number, row-major,
/// once every error is followed by FitFrame: of each marker alone.
std::vector<Matrix6> CovarianceInFittedFrame(const Object& object,
                                             const std::vector<double>& covariance);

}  // namespace topotag

#endif  // TOPOTAG_HOST_OBJECT_FRAME_H_
