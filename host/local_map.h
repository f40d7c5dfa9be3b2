#ifndef TOPOTAG_HOST_LOCAL_MAP_H_
#define TOPOTAG_HOST_LOCAL_MAP_H_

#include "host/homography.h"
#include "host/model.h"

namespace topotag {

/// A tag map linearised at a point: pixel = center + j * (units from the point).
struct LocalMap {
  LocalMap(const TagMap& map, Point2 tag) : center(map.Pixel(tag, &j)) {}

  double Determinant() const { return j[0] * j[3] - j[1] * j[2]; }

  Jacobian2 j;
  Point2 center;
};

/// The vertices of a marker, and the centre of its baseline node.
inline constexpr int kMaxPoints = kMaxVertices + 1;

/// Local maps of several points, in arrays of their parts, which loops take several at a time:
/// centre (x, y), Jacobian (xu, xv; yu, yv).
struct LocalMaps {
  /// @param tag  count <= kMaxPoints points, units
  LocalMaps(const TagMap& map, const Point2* tag, int count);

  double Determinant(int i) const { return xu[i] * yv[i] - xv[i] * yu[i]; }

  double x[kMaxPoints], y[kMaxPoints];
  double xu[kMaxPoints], xv[kMaxPoints], yu[kMaxPoints], yv[kMaxPoints];
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_LOCAL_MAP_H_
