#include "host/homography.h"

#include <cmath>

#include "host/pair.h"

namespace topotag {
namespace {

constexpr double kMinDenominator = 1e-6;
// Of a pivot, in parts of the sum that it is left of.
constexpr double kMinPivot = 1e-12;

struct Vector3d {
  double x, y, one;
};

// Weighted sums over the points of the products of (x, y, 1) with itself.
template <typename T>
struct MomentSums {
  T xx{}, xy{}, yy{}, x{}, y{}, one{};

  void Add(T px, T py, T weight) {
    const T wx = weight * px;
    const T wy = weight * py;
    xx += wx * px;
    xy += wx * py;
    yy += wy * py;
    x += wx;
    y += wy;
    one += weight;
  }
};

using Moments = MomentSums<double>;

Moments Sum(const MomentSums<Pair>& m) {
  return {SumLanes(m.xx), SumLanes(m.xy), SumLanes(m.yy),
          SumLanes(m.x),  SumLanes(m.y),  SumLanes(m.one)};
}

// Solves for symmetric positive definite 3 x 3 matrices, by their L D L' decomposition with the
// constant first.
class MomentSolver {
 public:
  explicit MomentSolver(const Moments& m)
      : mean_x_(m.x / m.one),
        mean_y_(m.y / m.one),
        inverse_one_(1 / m.one),
        inverse_xx_(1 / (m.xx - mean_x_ * m.x)),
        slope_((m.xy - mean_x_ * m.y) * inverse_xx_),
        inverse_yy_(1 / (m.yy - mean_y_ * m.y - slope_ * (m.xy - mean_x_ * m.y))),
        regular_(inverse_xx_ > 0 && inverse_xx_ * m.xx < 1 / kMinPivot && inverse_yy_ > 0 &&
                 inverse_yy_ * m.yy < 1 / kMinPivot) {}

  bool regular() const { return regular_; }
  Vector3d Solve(double x, double y, double one) const {
    const double rx = x - mean_x_ * one;
    const double ry = y - mean_y_ * one - slope_ * rx;
    const double sy = ry * inverse_yy_;
    const double sx = rx * inverse_xx_ - slope_ * sy;
    return {sx, sy, one * inverse_one_ - mean_x_ * sx - mean_y_ * sy};
  }

 private:
  double mean_x_, mean_y_, inverse_one_, inverse_xx_, slope_, inverse_yy_;
  bool regular_;
};

// What one image coordinate u, with the moments a of its weights times u, brings to the equations:
// its row of the map is constant + (x_slope, y_slope) (h6, h7).
struct Row {
  Row(const MomentSolver& solver, const Moments& a)
      : x_slope(solver.Solve(a.xx, a.xy, a.x)),
        y_slope(solver.Solve(a.xy, a.yy, a.y)),
        constant(solver.Solve(a.x, a.y, a.one)) {}

  Vector3d At(double h6, double h7) const {
    return {constant.x + x_slope.x * h6 + y_slope.x * h7,
            constant.y + x_slope.y * h6 + y_slope.y * h7,
            constant.one + x_slope.one * h6 + y_slope.one * h7};
  }
  Vector3d x_slope, y_slope, constant;
};

double DotX(const Moments& a, const Vector3d& v) { return a.xx * v.x + a.xy * v.y + a.x * v.one; }
double DotY(const Moments& a, const Vector3d& v) { return a.xy * v.x + a.yy * v.y + a.y * v.one; }

}  // namespace

bool SquareToQuad(double half, const Point2* quad, Homography* homography) {
  const Point2 d1{quad[1].x - quad[2].x, quad[1].y - quad[2].y};
  const Point2 d2{quad[3].x - quad[2].x, quad[3].y - quad[2].y};
  const Point2 s{quad[0].x - quad[1].x - d2.x, quad[0].y - quad[1].y - d2.y};
  const double det = d1.x * d2.y - d2.x * d1.y;
  // The map of the unit square has the denominator g s + h t + 1.
  const double g = (s.x * d2.y - d2.x * s.y) / det;
  const double h = (d1.x * s.y - s.x * d1.y) / det;
  if (!(std::abs(det) > 0 && 1 + g > kMinDenominator && 1 + h > kMinDenominator &&
        1 + g + h > kMinDenominator)) {
    return false;
  }
  const double scale = 1 / (2 + g + h);  // halved denominator at the square's centre
  const double per_unit = scale / half;
  const auto row = [&](double p0, double p1, double p3) {
    const double a = p1 - p0 + g * p1;
    const double b = p3 - p0 + h * p3;
    return Vector3{a * per_unit, b * per_unit, (a + b + 2 * p0) * scale};
  };
  homography->m = {row(quad[0].x, quad[1].x, quad[3].x),
                   row(quad[0].y, quad[1].y, quad[3].y),
                   {g * per_unit, h * per_unit, 1}};
  return true;
}

bool FitHomography(const Point2* from, const Point2* to, int n, const Homography& guess,
                   Homography* homography) {
  // For the rows h_u, h_v of the map and its denominator (h6, h7, 1): sum over the points of
  // w |(h_u a - u (h6 x + h7 y + 1), h_v a - v (..))|^2 is least, a = (x, y, 1). Given h6 and h7
  // both rows are linear fits with the same matrix; they are eliminated. The origin of u and v is
  // moved among the points: that keeps the digits.
  const Point2 origin{guess.m[0][2], guess.m[1][2]};
  MomentSums<Pair> plain_pairs, u_pairs, v_pairs, square_pairs;
  for (int i = 0; i < n; i += 2) {
    const int k = i + 1 < n ? i + 1 : i;  // an odd last point: no weight
    const Pair x = {from[i].x, from[k].x};
    const Pair y = {from[i].y, from[k].y};
    const Pair denominator = guess.m[2][0] * x + guess.m[2][1] * y + guess.m[2][2];
    const Pair w = Pair{1, k == i ? 0.0 : 1.0} / (denominator * denominator);
    const Pair u = Pair{to[i].x, to[k].x} - origin.x;
    const Pair v = Pair{to[i].y, to[k].y} - origin.y;
    plain_pairs.Add(x, y, w);
    u_pairs.Add(x, y, w * u);
    v_pairs.Add(x, y, w * v);
    square_pairs.Add(x, y, w * (u * u + v * v));
  }
  const Moments plain = Sum(plain_pairs), times_u = Sum(u_pairs), times_v = Sum(v_pairs);
  const Moments times_square = Sum(square_pairs);
  const MomentSolver solver(plain);
  if (!solver.regular()) return false;
  const Row u(solver, times_u);
  const Row v(solver, times_v);
  const double xx = times_square.xx - DotX(times_u, u.x_slope) - DotX(times_v, v.x_slope);
  const double xy = times_square.xy - DotX(times_u, u.y_slope) - DotX(times_v, v.y_slope);
  const double yy = times_square.yy - DotY(times_u, u.y_slope) - DotY(times_v, v.y_slope);
  const double x = DotX(times_u, u.constant) + DotX(times_v, v.constant) - times_square.x;
  const double y = DotY(times_u, u.constant) + DotY(times_v, v.constant) - times_square.y;
  const double det = xx * yy - xy * xy;
  if (!(xx > kMinPivot * times_square.xx && det > kMinPivot * xx * times_square.yy)) return false;
  const double h6 = (x * yy - y * xy) / det;
  const double h7 = (y * xx - x * xy) / det;
  for (int i = 0; i < n; ++i) {
    if (!(h6 * from[i].x + h7 * from[i].y + 1 > kMinDenominator)) return false;
  }
  const Vector3d ru = u.At(h6, h7);
  const Vector3d rv = v.At(h6, h7);
  homography->m = {{{ru.x + origin.x * h6, ru.y + origin.x * h7, ru.one + origin.x},
                    {rv.x + origin.y * h6, rv.y + origin.y * h7, rv.one + origin.y},
                    {h6, h7, 1}}};
  return true;
}

bool Invert(const Homography& homography, Homography* inverse) {
  const Matrix3& m = homography.m;
  const double scale = m[0][0] * m[1][1] - m[0][1] * m[1][0];
  if (!(std::abs(scale) > 0)) return false;
  const double s = 1 / scale;
  inverse->m = {
      {{(m[1][1] * m[2][2] - m[1][2] * m[2][1]) * s, (m[0][2] * m[2][1] - m[0][1] * m[2][2]) * s,
        (m[0][1] * m[1][2] - m[0][2] * m[1][1]) * s},
       {(m[1][2] * m[2][0] - m[1][0] * m[2][2]) * s, (m[0][0] * m[2][2] - m[0][2] * m[2][0]) * s,
        (m[0][2] * m[1][0] - m[0][0] * m[1][2]) * s},
       {(m[1][0] * m[2][1] - m[1][1] * m[2][0]) * s, (m[0][1] * m[2][0] - m[0][0] * m[2][1]) * s,
        1}}};
  return true;
}

Point2 TagMap::LensPixel(Point2 tag, Jacobian2* jacobian) const {
  Jacobian2 outer;
  Jacobian2 inner;
  const Point2 p = ideal.Map(tag, &inner);
  const Point2 normalized{(p.x - camera->cx) / camera->fx, (p.y - camera->cy) / camera->fy};
  if (jacobian == nullptr) return Project(*camera, normalized);
  const Point2 pixel = Project(*camera, normalized, &outer);
  for (size_t r = 0; r < 2; ++r) {
    for (size_t c = 0; c < 2; ++c) {
      (*jacobian)[2 * r + c] =
          outer[2 * r] / camera->fx * inner[c] + outer[2 * r + 1] / camera->fy * inner[2 + c];
    }
  }
  return pixel;
}

bool PixelToIdeal(const Camera* camera, Point2 pixel, Point2* ideal) {
  if (camera == nullptr || camera->model == DistortionModel::kNone) {
    *ideal = pixel;
    return true;
  }
  Point2 normalized;
  if (!Unproject(*camera, pixel, &normalized)) return false;
  *ideal = {camera->fx * normalized.x + camera->cx, camera->fy * normalized.y + camera->cy};
  return true;
}

}  // namespace topotag
