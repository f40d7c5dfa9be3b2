#include "host/outline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "host/check.h"

namespace topotag {
namespace {

// A mitre longer than this many offsets is cut square: corners sharper than about 47 degrees.
constexpr double kMitreLimit = 2.5;
// Points of an offset curve closer than this are one point. Far below anything printable, far
// above the rounding of coordinates that marker.cc limits to 10,000 units.
constexpr double kSamePoint = 1e-8;
// Where 1 + the cosine of a turn is below this, the outline turns back on itself: no digit of a
// mitre would be right.
constexpr double kReversal = 1e-12;
// An edge shorter than this has no direction: its squares are no full doubles.
constexpr double kShortestEdge = 1e-140;
// The cells of a curve's graph are counted in 64 bits.
constexpr double kMaxCurve = 1e9;

Point2 operator+(Point2 a, Point2 b) { return {a.x + b.x, a.y + b.y}; }
Point2 operator-(Point2 a, Point2 b) { return {a.x - b.x, a.y - b.y}; }
Point2 operator*(double s, Point2 a) { return {s * a.x, s * a.y}; }
double Dot(Point2 a, Point2 b) { return a.x * b.x + a.y * b.y; }
double Cross(Point2 a, Point2 b) { return a.x * b.y - a.y * b.x; }
double Norm(Point2 a) { return std::sqrt(Dot(a, a)); }

struct Segment {
  Point2 a, b;
};

Segment Edge(const Polygon& polygon, size_t i) {
  return {polygon[i], polygon[i + 1 == polygon.size() ? 0 : i + 1]};
}

bool BoxesMeet(const Segment& s, const Segment& t, double slack) {
  const auto meet = [slack](double a, double b, double c, double d) {
    return std::max(a, b) + slack >= std::min(c, d) && std::max(c, d) + slack >= std::min(a, b);
  };
  return meet(s.a.x, s.b.x, t.a.x, t.b.x) && meet(s.a.y, s.b.y, t.a.y, t.b.y);
}

// Calls visit(i, j), i != j, once for every pair of edges whose boxes come within `slack`, until
// it returns false. A sweep along x, so that an outline of thousands of points stays fast.
template <typename Visit>
void VisitClosePairs(const Polygon& polygon, double slack, Visit visit) {
  std::vector<size_t> order(polygon.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto left = [&](size_t i) {
    const Segment e = Edge(polygon, i);
    return std::min(e.a.x, e.b.x);
  };
  std::sort(order.begin(), order.end(), [&](size_t i, size_t j) { return left(i) < left(j); });
  for (size_t k = 0; k < order.size(); ++k) {
    const Segment s = Edge(polygon, order[k]);
    const double right = std::max(s.a.x, s.b.x) + slack;
    for (size_t m = k + 1; m < order.size() && left(order[m]) <= right; ++m) {
      if (!BoxesMeet(s, Edge(polygon, order[m]), slack)) continue;
      if (!visit(order[k], order[m])) return;
    }
  }
}

// With touching boxes, collinear segments meet as well: all four signs are zero.
bool Meet(const Segment& s, const Segment& t) {
  if (!BoxesMeet(s, t, 0)) return false;
  const auto sign = [](double v) { return (v > 0) - (v < 0); };
  const int ta = sign(Cross(s.b - s.a, t.a - s.a)), tb = sign(Cross(s.b - s.a, t.b - s.a));
  const int sa = sign(Cross(t.b - t.a, s.a - t.a)), sb = sign(Cross(t.b - t.a, s.b - t.a));
  return ta * tb <= 0 && sa * sb <= 0;
}

double Distance(Point2 p, const Segment& s) {
  const Point2 along = s.b - s.a;
  const double length2 = Dot(along, along);
  const double t = length2 > 0 ? std::clamp(Dot(p - s.a, along) / length2, 0.0, 1.0) : 0;
  return Norm(p - (s.a + t * along));
}

// The planar graph of a closed curve that may cross itself.
class CurveGraph {
 public:
  explicit CurveGraph(Polygon curve) {
    const auto same = [](Point2 a, Point2 b) { return Norm(a - b) < kSamePoint; };
    curve.erase(std::unique(curve.begin(), curve.end(), same), curve.end());
    while (curve.size() > 1 && same(curve.front(), curve.back())) curve.pop_back();
    std::vector<std::vector<std::pair<double, int>>> stops(curve.size());
    for (size_t i = 0; i < curve.size(); ++i) {
      stops[i].push_back({0, Node(Edge(curve, i).a)});
      stops[i].push_back({1, Node(Edge(curve, i).b)});
    }
    VisitClosePairs(curve, kSamePoint, [&](size_t i, size_t j) {
      AddCrossings(Edge(curve, i), Edge(curve, j), &stops[i], &stops[j]);
      return true;
    });
    for (auto& along : stops) {
      std::sort(along.begin(), along.end());
      for (size_t k = 1; k < along.size(); ++k) Link(along[k - 1].second, along[k].second);
    }
  }

  // Boundary of the unbounded face, with positive area. Empty where rounding broke the walk.
  Polygon OuterBoundary() const {
    if (nodes_.size() < 3) return {};
    const auto less = [](Point2 a, Point2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); };
    const int start =
        static_cast<int>(std::min_element(nodes_.begin(), nodes_.end(), less) - nodes_.begin());
    size_t steps = 2;
    for (const auto& n : neighbours_) steps += n.size();
    std::vector<int> path{start};
    const int first = Next(start, {-1, 0});
    for (int node = first; steps-- > 0;) {
      const int from = path.back();
      // An edge walked out and back again encloses nothing.
      if (path.size() >= 2 && path[path.size() - 2] == node) {
        path.pop_back();
      } else {
        path.push_back(node);
      }
      const int next = Next(node, nodes_[from] - nodes_[node]);
      if (node == start && next == first) {
        Polygon outline;
        for (size_t i = 0; i + 1 < path.size(); ++i) outline.push_back(nodes_[path[i]]);
        return outline;
      }
      node = next;
    }
    return {};
  }

 private:
  int Node(Point2 p) {
    const auto cell = [](double v) { return static_cast<int64_t>(std::floor(v / kSamePoint)); };
    const int64_t cx = cell(p.x), cy = cell(p.y);
    for (int64_t y = cy - 1; y <= cy + 1; ++y) {
      for (int64_t x = cx - 1; x <= cx + 1; ++x) {
        const auto found = cells_.find({x, y});
        if (found != cells_.end() && Norm(nodes_[found->second] - p) < kSamePoint) {
          return found->second;
        }
      }
    }
    nodes_.push_back(p);
    neighbours_.emplace_back();
    return cells_[{cx, cy}] = static_cast<int>(nodes_.size()) - 1;
  }

  void AddCrossings(const Segment& s, const Segment& t, std::vector<std::pair<double, int>>* on_s,
                    std::vector<std::pair<double, int>>* on_t) {
    const Point2 u = s.b - s.a, v = t.b - t.a;
    // Ends that lie on the other segment: T joints and collinear overlaps.
    const auto touch = [this](Point2 p, const Segment& on,
                              std::vector<std::pair<double, int>>* stops) {
      if (Distance(p, on) >= kSamePoint) return;
      const Point2 along = on.b - on.a;
      stops->push_back({std::clamp(Dot(p - on.a, along) / Dot(along, along), 0.0, 1.0), Node(p)});
    };
    touch(t.a, s, on_s);
    touch(t.b, s, on_s);
    touch(s.a, t, on_t);
    touch(s.b, t, on_t);
    const double det = Cross(u, v);
    if (std::abs(det) <= 1e-12 * Norm(u) * Norm(v)) return;
    const double along_s = Cross(t.a - s.a, v) / det;
    const double along_t = Cross(t.a - s.a, u) / det;
    if (along_s <= 0 || along_s >= 1 || along_t <= 0 || along_t >= 1) return;
    const int node = Node(s.a + along_s * u);
    on_s->push_back({along_s, node});
    on_t->push_back({along_t, node});
  }

  void Link(int a, int b) {
    if (a == b) return;
    if (std::find(neighbours_[a].begin(), neighbours_[a].end(), b) != neighbours_[a].end()) return;
    neighbours_[a].push_back(b);
    neighbours_[b].push_back(a);
  }

  // First neighbour met when turning from `back` (towards where the walk came from) through the
  // outside, which lies on the side of growing angle.
  int Next(int node, Point2 back) const {
    int best = -1;
    double best_angle = std::numeric_limits<double>::infinity();
    for (const int n : neighbours_[node]) {
      const Point2 to = nodes_[n] - nodes_[node];
      double angle = std::atan2(Cross(back, to), Dot(back, to));
      if (angle <= 1e-12) angle += 2 * M_PI;  // straight back is the last choice
      if (angle < best_angle) {
        best_angle = angle;
        best = n;
      }
    }
    return best;
  }

  std::vector<Point2> nodes_;
  std::vector<std::vector<int>> neighbours_;
  std::map<std::pair<int64_t, int64_t>, int> cells_;
};

// Appends the offset curve's points at corner p between edges of directions u and v.
void AppendCorner(Point2 p, Point2 u, Point2 v, double distance, double shorter_edge,
                  Polygon* curve) {
  const Point2 nu{u.y, -u.x}, nv{v.y, -v.x};
  const double cosine = Dot(u, v), sine = Cross(u, v);
  const bool reversal = 1 + cosine < kReversal;
  const double half_tangent = reversal ? 0 : std::abs(sine) / (1 + cosine);
  // A hollow corner whose edges are too short for the offset: the curve goes by way of the corner
  // itself, and the surplus is inside the outer boundary.
  if (sine < 0 && (reversal || 2 * distance * half_tangent > shorter_edge)) {
    curve->insert(curve->end(), {p + distance * nu, p, p + distance * nv});
    return;
  }
  const double mitre = std::sqrt(1 + half_tangent * half_tangent);
  if (!reversal && (sine < 0 || mitre <= kMitreLimit)) {
    curve->push_back(p + (distance / (1 + cosine)) * (nu + nv));
    return;
  }
  const Point2 tip = (1 / Norm(u - v)) * (u - v);
  const double beyond = distance * (kMitreLimit - Dot(nu, tip)) / Dot(u, tip);
  curve->push_back(p + distance * nu + beyond * u);
  curve->push_back(p + distance * nv - beyond * v);
}

}  // namespace

double SignedArea(const Polygon& polygon) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Segment e = Edge(polygon, i);
    twice += Cross(e.a - polygon[0], e.b - polygon[0]);
  }
  return twice / 2;
}

bool IsSimple(const Polygon& polygon) {
  const size_t count = polygon.size();
  if (count < 3) return false;
  for (size_t i = 0; i < count; ++i) {
    const Segment e = Edge(polygon, i), next = Edge(polygon, (i + 1) % count);
    if (e.a == e.b) return false;
    if (Cross(e.b - e.a, next.b - next.a) == 0 && Dot(e.b - e.a, next.b - next.a) < 0) return false;
  }
  bool simple = true;
  VisitClosePairs(polygon, 0, [&](size_t i, size_t j) {
    const bool neighbours = (i + 1) % count == j || (j + 1) % count == i;
    simple = neighbours || !Meet(Edge(polygon, i), Edge(polygon, j));
    return simple;
  });
  return simple;
}

bool Contains(const Polygon& polygon, Point2 point) {
  bool inside = false;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Segment e = Edge(polygon, i);
    if ((e.a.y > point.y) == (e.b.y > point.y)) continue;
    const double x = e.a.x + (point.y - e.a.y) / (e.b.y - e.a.y) * (e.b.x - e.a.x);
    if (point.x < x) inside = !inside;
  }
  return inside;
}

double DistanceToOutline(const Polygon& polygon, Point2 point) {
  double distance = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < polygon.size(); ++i) {
    distance = std::min(distance, Distance(point, Edge(polygon, i)));
  }
  return distance;
}

double DistanceBetween(const Polygon& a, const Polygon& b) {
  double distance = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < a.size(); ++i) {
    distance = std::min(distance, DistanceToOutline(b, a[i]));
    for (size_t j = 0; j < b.size(); ++j) {
      if (Meet(Edge(a, i), Edge(b, j))) return 0;
    }
  }
  for (const Point2& p : b) distance = std::min(distance, DistanceToOutline(a, p));
  return distance;
}

Polygon OffsetOutwards(const Polygon& polygon, double distance) {
  Polygon corners;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Segment edge = Edge(polygon, i);
    if (!(Norm(edge.b - edge.a) < kShortestEdge)) corners.push_back(edge.a);
  }
  const size_t count = corners.size();
  Polygon curve;
  for (size_t i = 0; i < count; ++i) {
    const Segment in = Edge(corners, (i + count - 1) % count), out = Edge(corners, i);
    const double in_length = Norm(in.b - in.a), out_length = Norm(out.b - out.a);
    AppendCorner(corners[i], (1 / in_length) * (in.b - in.a), (1 / out_length) * (out.b - out.a),
                 distance, std::min(in_length, out_length), &curve);
  }
  // Written so that NaN is not bounded.
  const bool bounded = std::all_of(curve.begin(), curve.end(), [](Point2 p) {
    return std::abs(p.x) <= kMaxCurve && std::abs(p.y) <= kMaxCurve;
  });
  Polygon outline;
  if (bounded) outline = CurveGraph(std::move(curve)).OuterBoundary();
  if (outline.size() < 3) {
    FailArgument("polygon cannot be widened by " + Text(distance) + " units");
  }
  return outline;
}

}  // namespace topotag
