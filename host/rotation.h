#ifndef TOPOTAG_HOST_ROTATION_H_
#define TOPOTAG_HOST_ROTATION_H_

#include "topotag/geometry.h"

namespace topotag {

/// Rotation matrix of a rotation vector (axis times angle, radians).
Matrix3 Exp(const Vector3& w);
Matrix3 Transposed(const Matrix3& r);

}  // namespace topotag

#endif  // TOPOTAG_HOST_ROTATION_H_
