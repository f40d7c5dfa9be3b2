#ifndef TOPOTAG_HOST_OUTLINE_H_
#define TOPOTAG_HOST_OUTLINE_H_

#include <vector>

#include "topotag/geometry.h"

namespace topotag {

/// Points of a closed outline; the last point is joined to the first.
using Polygon = std::vector<Point2>;

/// Shoelace area: positive where the outline turns from +x to +y (clockwise on screen).
double SignedArea(const Polygon& polygon);

/// False where two edges touch or cross, an edge turns back on itself, or a point is repeated.
bool IsSimple(const Polygon& polygon);

/// Even-odd test; points on the outline itself may fall on either side.
bool Contains(const Polygon& polygon, Point2 point);

/// Distance from a point to the outline, whichever side it is on.
double DistanceToOutline(const Polygon& polygon, Point2 point);

/// Smallest distance between two outlines; 0 where they touch or cross.
double DistanceBetween(const Polygon& a, const Polygon& b);

/// Outer outline of a simple polygon of positive area, moved outwards by `distance` > 0, in the
/// polygon's own units. Convex corners are mitred, very sharp ones cut square. Bays that the
/// offset closes are filled, so the result has no hole.
/// @throws Error (kInvalidArgument) where rounding leaves no closed outline.
Polygon OffsetOutwards(const Polygon& polygon, double distance);

}  // namespace topotag

#endif  // TOPOTAG_HOST_OUTLINE_H_
