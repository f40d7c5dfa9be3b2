#include "host/decode.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/local_map.h"
#include "host/model.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

constexpr double kPitch = 4;        // units
constexpr double kCornerFit = 1.4;  // node centre to grid under the corners' homography, units
constexpr double kGridFit = 0.6;    // under the homography of all nodes, units
constexpr double kGridFitRms = 0.3;
constexpr double kHoleFit = 0.8;  // hole centre to node centre, units
// Areas in square units, holes included: a square node has 9, a circle 7.1; bright and dark
// thresholds, blur and ink spread take their share.
constexpr double kMinNodeArea = 3;
constexpr double kMaxNodeArea = 16;
// Of one node to the median. At the limit of what is resolved areas scatter by 1.35; a node of
// which a third is covered is out.
constexpr float kMaxAreaRatio = 1.45F;
constexpr double kMaxClipped = 1.0;  // pixels of the white square outside the image

double Cross(Point2 a, Point2 b, Point2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double Square(double x) { return x * x; }

double SquaredDistance(Point2 a, Point2 b) { return Square(a.x - b.x) + Square(a.y - b.y); }

// The points of one candidate in ideal pixels: point 0 and 1 are the baseline node's holes, the
// others the nodes.
struct Points {
  int count = 0;
  std::array<Point2, kMaxVertices> at;
  std::array<const Node*, kMaxVertices> node{};
};

bool GatherPoints(const Candidate& candidate, const Node* nodes, const Camera* camera,
                  const SearchArea& area, Points* points) {
  const auto add = [&](const Node& node, Point2 place) {
    const auto k = static_cast<size_t>(points->count++);
    points->node[k] = &node;
    return PixelToIdeal(camera, place, &points->at[k]);
  };
  const Node& baseline = nodes[candidate.baseline];
  for (const Feature& hole : baseline.holes) {
    if (!add(baseline, area.CentroidInFrame(hole))) return false;
  }
  for (int i = 0; i < candidate.node_count; ++i) {
    if (i == candidate.baseline) continue;
    const Node& node = nodes[i];
    int64_t sum_x = node.black.sum_x;
    int64_t sum_y = node.black.sum_y;
    uint32_t pixels = node.black.area;
    if (node.hole_count == 1) {
      sum_x += node.holes[0].sum_x;
      sum_y += node.holes[0].sum_y;
      pixels += node.holes[0].area;
    }
    if (!add(node, area.CentroidInFrame(sum_x, sum_y, pixels))) return false;
  }
  return true;
}

struct Hull {
  int size = 0;
  std::array<int, 2 * kMaxVertices> point;  ///< indices of points
};

// Convex hull, clockwise as seen on the screen (y points down), by Andrew's monotone chain from
// top to bottom and back: the nodes come nearly in that order.
Hull ConvexHull(const Points& points) {
  std::array<int, kMaxVertices> order;
  const auto at = [&](int i) { return points.at[static_cast<size_t>(i)]; };
  for (int i = 0; i < points.count; ++i) {
    const Point2 p = at(i);
    int k = i;
    for (; k > 0; --k) {
      const int previous = order[static_cast<size_t>(k - 1)];
      const Point2 q = at(previous);
      if (q.y < p.y || (q.y == p.y && q.x <= p.x)) break;
      order[static_cast<size_t>(k)] = previous;
    }
    order[static_cast<size_t>(k)] = i;
  }
  Hull hull;
  const auto add = [&](int i, int keep) {
    while (hull.size >= keep + 2 &&
           Cross(at(hull.point[static_cast<size_t>(hull.size - 2)]),
                 at(hull.point[static_cast<size_t>(hull.size - 1)]), at(i)) <= 0) {
      --hull.size;
    }
    hull.point[static_cast<size_t>(hull.size++)] = i;
  };
  for (int k = 0; k < points.count; ++k) add(order[static_cast<size_t>(k)], 0);
  const int last = hull.size - 1;
  for (int k = points.count - 2; k >= 0; --k) add(order[static_cast<size_t>(k)], last);
  --hull.size;  // the first point again
  return hull;
}

// Corners of the largest quadrilateral among the hull's points that starts at hull index `first`,
// clockwise: for each opposite corner the best corner on either side. As the opposite corner
// advances, neither of them goes back.
bool LargestQuad(const Points& points, const Hull& hull, int first, std::array<Point2, 4>* quad) {
  std::array<Point2, 2 * kMaxVertices> at;  // from the first corner on
  for (int k = 0; k < hull.size; ++k) {
    const int i = first + k < hull.size ? first + k : first + k - hull.size;
    at[static_cast<size_t>(k)] = points.at[static_cast<size_t>(hull.point[static_cast<size_t>(i)])];
  }
  const auto area = [&](size_t opposite, size_t k) {
    return std::abs(Cross(at[0], at[opposite], at[k]));
  };
  double best = 0;
  size_t second = 1;
  size_t fourth = 3;
  const auto size = static_cast<size_t>(hull.size);
  for (size_t opposite = 2; opposite + 1 < size; ++opposite) {
    while (second + 1 < opposite && area(opposite, second + 1) > area(opposite, second)) ++second;
    fourth = std::max(fourth, opposite + 1);
    while (fourth + 1 < size && area(opposite, fourth + 1) > area(opposite, fourth)) ++fourth;
    const double right = area(opposite, second);
    const double left = area(opposite, fourth);
    if (right > 0 && left > 0 && right + left > best) {
      best = right + left;
      *quad = {at[0], at[second], at[opposite], at[fourth]};
    }
  }
  return best > 0;
}

// A reading of the grid: which point is which vertex.
struct Reading {
  std::array<int, kMaxVertices> point;  ///< of each vertex
  Homography map;                       ///< tag units to ideal pixels
};

// Assigns every point to the vertex that `inverse` (ideal pixels to units) takes it to; p1 is
// point `p1`. False unless each vertex gets exactly one.
bool Assign(const Points& points, Family family, int p1, const Homography& inverse,
            Reading* reading) {
  const int n = family.n();
  const double first = -kPitch / 2 * (n - 1);
  const Point2* model = ModelTable(family);
  uint64_t taken = 0;
  for (int i = 0; i < points.count; ++i) {
    const Point2 tag = inverse.Map(points.at[static_cast<size_t>(i)]);
    int vertex;
    if (i < 2) {
      vertex = i == p1 ? 0 : 1;
    } else {
      const double col = (tag.x - first) / kPitch + 0.5;
      const double row = (tag.y - first) / kPitch + 0.5;
      if (!(col >= 0 && col < n && row >= 0 && row < n)) return false;
      vertex = static_cast<int>(row) * n + static_cast<int>(col);
      if (vertex < 2) return false;
    }
    if (!(SquaredDistance(tag, model[vertex]) < Square(kCornerFit))) return false;
    if ((taken >> vertex & 1) != 0) return false;
    taken |= uint64_t{1} << vertex;
    reading->point[static_cast<size_t>(vertex)] = i;
  }
  return true;
}

// Fits the homography to all vertices and checks that each lies where it belongs.
bool Confirm(const Points& points, Family family, const Homography& corners, Reading* reading) {
  const Point2* model = ModelTable(family);
  std::array<Point2, kMaxVertices> image;
  const int count = family.vertex_count();
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<size_t>(i);
    image[k] = points.at[static_cast<size_t>(reading->point[k])];
  }
  Homography inverse;
  if (!FitHomography(model, image.data(), count, corners, &reading->map) ||
      !Invert(reading->map, &inverse)) {
    return false;
  }
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    const double error = SquaredDistance(inverse.Map(image[static_cast<size_t>(i)]), model[i]);
    if (!(error < Square(kGridFit))) return false;
    sum += error;
  }
  return sum < Square(kGridFitRms) * count;
}

bool ReadGrid(const Points& points, Family family, int p1, const Hull& hull, Reading* reading) {
  const auto end = hull.point.begin() + hull.size;
  const auto start = std::find(hull.point.begin(), end, p1);
  std::array<Point2, 4> quad;
  if (start == end ||
      !LargestQuad(points, hull, static_cast<int>(start - hull.point.begin()), &quad)) {
    return false;
  }
  Homography map;
  Homography inverse;
  return SquareToQuad(kPitch / 2 * (family.n() - 1), quad.data(), &map) && Invert(map, &inverse) &&
         Assign(points, family, p1, inverse, reading) && Confirm(points, family, map, reading);
}

// The hole of the baseline node that is tried first as p1, the corner: the one farther from the
// middle of all nodes.
int LikelyCorner(const Points& points) {
  Point2 sum;
  for (int i = 0; i < points.count; ++i) {
    sum.x += points.at[static_cast<size_t>(i)].x;
    sum.y += points.at[static_cast<size_t>(i)].y;
  }
  const Point2 middle{sum.x / points.count, sum.y / points.count};
  return SquaredDistance(points.at[0], middle) >= SquaredDistance(points.at[1], middle) ? 0 : 1;
}

// Black area and holes, in pixels of the labelled image.
double WholeArea(const Node& node) {
  double area = node.black.area;
  for (int i = 0; i < node.hole_count; ++i) area += node.holes[static_cast<size_t>(i)].area;
  return area;
}

// The element that count / 2 others precede. Counting needs no branches, and few are counted.
float Median(const std::array<float, kMaxVertices>& values, int count) {
  const float* begin = values.data();
  for (int i = 0; i < count; ++i) {
    const float value = begin[i];
    int below = 0;
    int same = 0;
    for (int k = 0; k < count; ++k) {
      below += begin[k] < value;
      same += begin[k] == value;
    }
    if (below <= count / 2 && count / 2 < below + same) return value;
  }
  return NAN;
}

// Sizes of all nodes and places of all holes.
bool CheckNodes(const Points& points, Family family, const Reading& reading, const SearchArea& area,
                const TagMap& map, double* median_area) {
  std::array<float, kMaxVertices> areas;
  const int count = family.bits();
  const LocalMaps maps(map, ModelTable(family) + 2, count);
  bool fit = true;
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<size_t>(i);
    const Node& node = *points.node[static_cast<size_t>(reading.point[k + 2])];
    const double unit_area = std::abs(maps.Determinant(i));  // pixels
    areas[k] = static_cast<float>(WholeArea(node) / (area.scale * area.scale * unit_area));
    if (node.hole_count == 0) continue;
    const Feature& f = node.holes[0];
    const Point2 hole = area.CentroidInFrame(f);
    const double dx = hole.x - maps.x[i];
    const double dy = hole.y - maps.y[i];
    const double squared_distance =  // units times unit_area
        Square(maps.yv[i] * dx - maps.xv[i] * dy) + Square(maps.xu[i] * dy - maps.yu[i] * dx);
    fit &= squared_distance < Square(kHoleFit * unit_area);
  }
  if (!fit) return false;
  const float median = Median(areas, count);
  if (!(median > kMinNodeArea && median < kMaxNodeArea)) return false;
  *median_area = median;
  for (int i = 0; i < count; ++i) {
    const float a = areas[static_cast<size_t>(i)];
    fit &= a < kMaxAreaRatio * median && a * kMaxAreaRatio > median;
  }
  return fit;
}

// A white area that reaches the border of what is searched may go on beyond it, and the nodes that
// are left may even form a smaller grid. Accepted is only what fills the area exactly: it reaches
// all four sides, and the corners of its white square lie within.
bool IsClipped(const Candidate& candidate, const TagMap& map, const SearchArea& area) {
  const Rect& whole = area.whole;
  const int x_end = whole.x + whole.width;
  const int y_end = whole.y + whole.height;
  const Point2 first = area.ToFrame(candidate.white.min_x, candidate.white.min_y);
  const Point2 last = area.ToFrame(candidate.white.max_x, candidate.white.max_y);
  const int reached = (first.x < whole.x + 0.5) + (first.y < whole.y + 0.5) +
                      (last.x > x_end - 1.5) + (last.y > y_end - 1.5);
  if (reached == 0) return false;
  if (reached < 4) return true;

  const double half = candidate.family.white_side() / 2.0;
  const double margin = 0.5 + kMaxClipped;
  for (const Point2 corner : {Point2{-half, -half}, {half, -half}, {half, half}, {-half, half}}) {
    const Point2 p = map.Pixel(corner);
    if (!(p.x >= whole.x - margin && p.x <= x_end - 1 + margin && p.y >= whole.y - margin &&
          p.y <= y_end - 1 + margin)) {
      return true;
    }
  }
  return false;
}

}  // namespace

bool Decode(const Candidate& candidate, const Node* nodes, const Camera* camera,
            const SearchArea& area, Decoded* decoded) {
  Points points;
  if (!GatherPoints(candidate, nodes, camera, area, &points)) return false;
  const Hull hull = ConvexHull(points);
  const int p1 = LikelyCorner(points);
  Reading best;
  if (!ReadGrid(points, candidate.family, p1, hull, &best) &&
      !ReadGrid(points, candidate.family, 1 - p1, hull, &best)) {
    return false;
  }
  if (!IsInFront(best.map, candidate.family.white_side() / 2.0)) return false;

  decoded->family = candidate.family;
  decoded->hidden = decoded->unmeasured = 0;
  decoded->map = {best.map, camera};
  if (!CheckNodes(points, candidate.family, best, area, decoded->map, &decoded->node_area) ||
      IsClipped(candidate, decoded->map, area)) {
    return false;
  }
  uint64_t bits = 0;
  for (int i = 2; i < candidate.family.vertex_count(); ++i) {
    const Node& node = *points.node[static_cast<size_t>(best.point[static_cast<size_t>(i)])];
    bits |= static_cast<uint64_t>(node.hole_count) << i;
  }
  decoded->id = IdFromVertexBits(candidate.family, bits);
  return true;
}

bool IsInFront(const Homography& map, double half) {
  for (const double x : {-half, half}) {
    for (const double y : {-half, half}) {
      if (!(map.Denominator({x, y}) > 0.05)) return false;
    }
  }
  return true;
}

}  // namespace topotag
