#include "host/bias.h"

namespace topotag {
namespace {

// Step of the lens's derivatives, in normalised coordinates: small enough for one-sided
// differences, large enough for their digits.
constexpr double kStep = 1e-4;

double Determinant(const Jacobian2& j) { return j[0] * j[3] - j[1] * j[2]; }

}  // namespace

Point2 LensBias(const TagMap& map, Point2 tag, Point2 second_moment) {
  const Camera& camera = *map.camera;
  Jacobian2 inner;
  const Point2 p = map.ideal.Map(tag, &inner);
  const double fx = 1 / camera.fx;
  const double fy = 1 / camera.fy;
  const Point2 q{(p.x - camera.cx) * fx, (p.y - camera.cy) * fy};
  Jacobian2 at, right, below;
  Project(camera, q, &at);
  Project(camera, {q.x + kStep, q.y}, &right);
  Project(camera, {q.x, q.y + kStep}, &below);
  const double det = Determinant(at);
  if (!(det > 0)) return {};  // beyond the lens model's range
  const double growth_x = (Determinant(right) - det) / det;
  const double growth_y = (Determinant(below) - det) / det;
  Point2 bias;
  for (size_t axis = 0; axis < 2; ++axis) {
    const double moment = (axis == 0 ? second_moment.x : second_moment.y) / kStep;
    // Of q, by one unit of the axis.
    const double x = inner[axis] * fx;
    const double y = inner[2 + axis] * fy;
    const double growth = growth_x * x + growth_y * y;
    const auto along = [&](size_t row) {
      const double xx = right[row] - at[row];
      const double xy = right[row + 1] - at[row + 1];
      const double yy = below[row + 1] - at[row + 1];
      const double second = (xx * x + 2 * xy * y) * x + yy * y * y;
      return moment * (second / 2 + (at[row] * x + at[row + 1] * y) * growth);
    };
    bias.x += along(0);
    bias.y += along(2);
  }
  return bias;
}

}  // namespace topotag
