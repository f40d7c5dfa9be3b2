#ifndef TOPOTAG_HOST_BIAS_H_
#define TOPOTAG_HOST_BIAS_H_

#include "host/local_map.h"

namespace topotag {

/// Centroid of a projected shape minus the projection of its centre, to second order, pixels, for a
/// shape symmetric in u and v with the second moments m (mean of u^2 and of v^2, square units). The
/// mean of the point x(u, v) over the image of the shape, whose area element is |J|, is
/// x + sum over u, v of m_u (x_uu / 2 + x_u (ln |J|)_u). For a homography with denominator w,
/// |J| ~ w^-3, x_uu = -2 (h31 / w) x_u, (ln |J|)_u = -3 h31 / w: -4 m_u (h31 / w) x_u. A lens adds
/// its own curvature.

/// What the homography brings, per unit of m.x and of m.y times the columns of the Jacobian.
inline Point2 PerspectiveBias(const Homography& ideal, Point2 tag) {
  const double scale = -4 / ideal.Denominator(tag);
  return {scale * ideal.m[2][0], scale * ideal.m[2][1]};
}

/// What the lens adds at a point, pixels. It hardly changes with the map.
Point2 LensBias(const TagMap& map, Point2 tag, Point2 second_moment);

}  // namespace topotag

#endif  // TOPOTAG_HOST_BIAS_H_
