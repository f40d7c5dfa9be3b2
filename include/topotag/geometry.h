#ifndef TOPOTAG_GEOMETRY_H_
#define TOPOTAG_GEOMETRY_H_

#include <array>

namespace topotag {

/// Image points: pixels, (0, 0) = centre of the top-left pixel, x right, y down.
/// Tag points: units, origin at the tag's centre, x along the rows, y towards later rows.
struct Point2 {
  double x = 0;
  double y = 0;
};

inline bool operator==(const Point2& a, const Point2& b) { return a.x == b.x && a.y == b.y; }

struct Rect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

using Vector3 = std::array<double, 3>;
using Matrix3 = std::array<std::array<double, 3>, 3>;  ///< row-major: m[row][column]
using Matrix6 = std::array<std::array<double, 6>, 6>;  ///< row-major: m[row][column]

}  // namespace topotag

#endif  // TOPOTAG_GEOMETRY_H_
