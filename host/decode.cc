#include "host/decode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "host/sample.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

constexpr double kPitch = 4;        // units
constexpr double kCornerFit = 1.4;  // node centre to grid under the corners' homography, units
constexpr double kGridFit = 0.8;    // under the homography of all nodes, units
constexpr double kGridFitRms = 0.4;
constexpr double kHoleFit = 0.8;  // hole centre to node centre, units
// Areas in square units, holes included: a square node has 9, a circle 7.1; bright and dark
// thresholds, blur and ink spread take their share.
constexpr double kMinNodeArea = 3;
constexpr double kMaxNodeArea = 16;
constexpr double kMaxAreaRatio = 2.2;  // of one node to the median
constexpr double kMaxClipped = 1.0;    // pixels of the white square outside the image

double Cross(Point2 a, Point2 b, Point2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

Point2 Centroid(const Feature& f, const SearchArea& area) {
  return area.ToFrame(static_cast<double>(f.sum_x) / f.area, static_cast<double>(f.sum_y) / f.area);
}

// The points of one candidate in ideal pixels: point 0 and 1 are the baseline node's holes, the
// others the nodes.
struct Points {
  int count = 0;
  std::array<Point2, kMaxVertices> at;
  std::array<const Node*, kMaxVertices> node{};
};

bool GatherPoints(const Candidate& candidate, const Node* nodes, const Camera* camera,
                  const SearchArea& area, Points* points) {
  const Node& baseline = nodes[candidate.baseline];
  for (const Feature& hole : baseline.holes) {
    points->node[static_cast<size_t>(points->count)] = &baseline;
    points->at[static_cast<size_t>(points->count++)] = Centroid(hole, area);
  }
  for (int i = 0; i < candidate.node_count; ++i) {
    if (i == candidate.baseline) continue;
    Feature whole = nodes[i].black;
    if (nodes[i].hole_count == 1) {
      whole.area += nodes[i].holes[0].area;
      whole.sum_x += nodes[i].holes[0].sum_x;
      whole.sum_y += nodes[i].holes[0].sum_y;
    }
    points->node[static_cast<size_t>(points->count)] = &nodes[i];
    points->at[static_cast<size_t>(points->count++)] = Centroid(whole, area);
  }
  for (int i = 0; i < points->count; ++i) {
    Point2& p = points->at[static_cast<size_t>(i)];
    if (!PixelToIdeal(camera, p, &p)) return false;
  }
  return true;
}

using Hull = std::array<int, 2 * kMaxVertices>;  // indices of points

// Convex hull, clockwise as seen on the screen (y points down), by Andrew's monotone chain.
int ConvexHull(const Points& points, Hull* hull) {
  std::array<int, kMaxVertices> order;
  for (int i = 0; i < points.count; ++i) order[static_cast<size_t>(i)] = i;
  const auto at = [&](int i) { return points.at[static_cast<size_t>(i)]; };
  std::sort(order.begin(), order.begin() + points.count, [&](int a, int b) {
    return std::make_tuple(at(a).x, at(a).y, a) < std::make_tuple(at(b).x, at(b).y, b);
  });
  int size = 0;
  const auto add = [&](int i, int keep) {
    while (size >= keep + 2 && Cross(at((*hull)[static_cast<size_t>(size - 2)]),
                                     at((*hull)[static_cast<size_t>(size - 1)]), at(i)) <= 0) {
      --size;
    }
    (*hull)[static_cast<size_t>(size++)] = i;
  };
  for (int k = 0; k < points.count; ++k) add(order[static_cast<size_t>(k)], 0);
  const int upper = size - 1;
  for (int k = points.count - 2; k >= 0; --k) add(order[static_cast<size_t>(k)], upper);
  return size - 1;
}

// Corners of the largest quadrilateral among the hull's points that starts at hull index `first`,
// clockwise: for each opposite corner the best corner on either side.
bool LargestQuad(const Points& points, const Hull& hull, int size, int first,
                 std::array<Point2, 4>* quad) {
  const auto at = [&](int k) {
    return points.at[static_cast<size_t>(hull[static_cast<size_t>((first + k) % size)])];
  };
  double best = 0;
  for (int opposite = 2; opposite + 1 < size; ++opposite) {
    const auto farthest = [&](int begin, int end, double* area) {
      int found = begin;
      for (int k = begin; k < end; ++k) {
        const double a = std::abs(Cross(at(0), at(opposite), at(k)));
        if (a > *area) {
          *area = a;
          found = k;
        }
      }
      return found;
    };
    double right = 0;
    double left = 0;
    const int second = farthest(1, opposite, &right);
    const int fourth = farthest(opposite + 1, size, &left);
    if (right > 0 && left > 0 && right + left > best) {
      best = right + left;
      *quad = {at(0), at(second), at(opposite), at(fourth)};
    }
  }
  return best > 0;
}

// A reading of the grid: which point is which vertex.
struct Reading {
  std::array<int, kMaxVertices> point;  ///< of each vertex
  Homography map;                       ///< tag units to ideal pixels
  double rms = 0;                       ///< of all vertices, units
};

// Assigns every point to the vertex that `inverse` (ideal pixels to units) takes it to; p1 is
// point `p1`. False unless each vertex gets exactly one.
bool Assign(const Points& points, Family family, int p1, const Homography& inverse,
            Reading* reading) {
  const int n = family.n();
  const double first = -kPitch / 2 * (n - 1);
  std::array<bool, kMaxVertices> taken{};
  for (int i = 0; i < points.count; ++i) {
    const Point2 tag = inverse.Map(points.at[static_cast<size_t>(i)]);
    int vertex;
    if (i < 2) {
      vertex = i == p1 ? 0 : 1;
    } else {
      const double col = std::round((tag.x - first) / kPitch);
      const double row = std::round((tag.y - first) / kPitch);
      if (!(col >= 0 && col < n && row >= 0 && row < n)) return false;
      vertex = static_cast<int>(row) * n + static_cast<int>(col);
      if (vertex < 2) return false;
    }
    const Point2 model = ModelVertex(family, vertex);
    if (!(std::hypot(tag.x - model.x, tag.y - model.y) < kCornerFit)) return false;
    if (taken[static_cast<size_t>(vertex)]) return false;
    taken[static_cast<size_t>(vertex)] = true;
    reading->point[static_cast<size_t>(vertex)] = i;
  }
  return true;
}

// Fits the homography to all vertices and checks that each lies where it belongs.
bool Confirm(const Points& points, Family family, Reading* reading) {
  std::array<Point2, kMaxVertices> model;
  std::array<Point2, kMaxVertices> image;
  const int count = family.vertex_count();
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<size_t>(i);
    model[k] = ModelVertex(family, i);
    image[k] = points.at[static_cast<size_t>(reading->point[k])];
  }
  Homography inverse;
  if (!FitHomography(model.data(), image.data(), count, &reading->map) ||
      !Invert(reading->map, &inverse)) {
    return false;
  }
  double sum = 0;
  for (size_t k = 0; k < static_cast<size_t>(count); ++k) {
    const Point2 tag = inverse.Map(image[k]);
    const double error = std::hypot(tag.x - model[k].x, tag.y - model[k].y);
    if (!(error < kGridFit)) return false;
    sum += error * error;
  }
  reading->rms = std::sqrt(sum / count);
  return reading->rms < kGridFitRms;
}

bool ReadGrid(const Points& points, Family family, int p1, const Hull& hull, int hull_size,
              Reading* reading) {
  const auto end = hull.begin() + hull_size;
  const auto start = std::find(hull.begin(), end, p1);
  std::array<Point2, 4> quad;
  if (start == end ||
      !LargestQuad(points, hull, hull_size, static_cast<int>(start - hull.begin()), &quad)) {
    return false;
  }
  const double c = kPitch / 2 * (family.n() - 1);
  const Point2 model[4] = {{-c, -c}, {c, -c}, {c, c}, {-c, c}};
  Homography map;
  Homography inverse;
  return FitHomography(model, quad.data(), 4, &map) && Invert(map, &inverse) &&
         Assign(points, family, p1, inverse, reading) && Confirm(points, family, reading);
}

// Black area and holes, in pixels of the labelled image.
double WholeArea(const Node& node) {
  double area = node.black.area;
  for (int i = 0; i < node.hole_count; ++i) area += node.holes[static_cast<size_t>(i)].area;
  return area;
}

// Sizes of all nodes and places of all holes.
bool CheckNodes(const Points& points, Family family, const Reading& reading, const SearchArea& area,
                const TagMap& map, double* median_area) {
  std::array<double, kMaxVertices> areas;
  const int count = family.bits();
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<size_t>(i);
    const Node& node = *points.node[static_cast<size_t>(reading.point[k + 2])];
    const LocalMap local(map, ModelVertex(family, i + 2));
    const double unit_area = std::abs(local.Determinant());  // pixels
    areas[k] = WholeArea(node) / (area.scale * area.scale * unit_area);
    if (node.hole_count == 0) continue;
    const Jacobian2& j = local.j;
    const Point2 hole = Centroid(node.holes[0], area);
    const double dx = hole.x - local.center.x;
    const double dy = hole.y - local.center.y;
    if (!(std::hypot(j[3] * dx - j[1] * dy, j[0] * dy - j[2] * dx) < kHoleFit * unit_area)) {
      return false;
    }
  }
  std::array<double, kMaxVertices> sorted = areas;
  const auto middle = sorted.begin() + count / 2;
  std::nth_element(sorted.begin(), middle, sorted.begin() + count);
  *median_area = *middle;
  if (!(*median_area > kMinNodeArea && *median_area < kMaxNodeArea)) return false;
  return std::all_of(areas.begin(), areas.begin() + count, [&](double a) {
    return a < kMaxAreaRatio * *median_area && a * kMaxAreaRatio > *median_area;
  });
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

// The horizon must not cross the white square.
bool IsInFront(const Homography& map, double half) {
  for (const double x : {-half, half}) {
    for (const double y : {-half, half}) {
      if (!(map.Denominator({x, y}) > 0.05)) return false;
    }
  }
  return true;
}

}  // namespace

bool Decode(const Candidate& candidate, const Node* nodes, const Camera* camera,
            const SearchArea& area, Decoded* decoded) {
  Points points;
  if (!GatherPoints(candidate, nodes, camera, area, &points)) return false;
  Hull hull;
  const int hull_size = ConvexHull(points, &hull);
  Reading best;
  bool found = false;
  for (int p1 = 0; p1 < 2; ++p1) {
    Reading reading;
    if (!ReadGrid(points, candidate.family, p1, hull, hull_size, &reading)) continue;
    if (!found || reading.rms < best.rms) best = reading;
    found = true;
  }
  if (!found || !IsInFront(best.map, candidate.family.white_side() / 2.0)) return false;

  decoded->family = candidate.family;
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

}  // namespace topotag
