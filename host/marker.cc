#include "topotag/marker.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "host/check.h"
#include "host/outline.h"

namespace topotag {
namespace {

constexpr double kNodeWidth = 3;
constexpr double kHoleWidth = 1;
constexpr double kClearance = 0.5;
// Limits that keep every later computation far from overflow and from quadratic run times.
constexpr double kMaxLength = 10000;
constexpr size_t kMaxPolygonPoints = 4000;

// Right half of the butterfly, from between the upper wings down to between the lower ones, in
// sides of the white square; the left half mirrors it. The square (half side 0.5) fits inside.
constexpr Point2 kButterflyHalf[] = {
    {0, -0.80},    {0.07, -0.77}, {0.10, -0.66}, {0.17, -0.62}, {0.36, -0.80}, {0.68, -1.06},
    {1.04, -1.16}, {1.24, -1.04}, {1.22, -0.70}, {1.08, -0.32}, {0.86, -0.04}, {0.70, 0.10},
    {0.84, 0.24},  {0.94, 0.48},  {0.90, 0.78},  {0.70, 0.96},  {0.44, 0.92},  {0.24, 0.72},
    {0.11, 0.60},  {0.05, 0.68},  {0, 0.74}};
constexpr int kButterflySteps = 8;  // chords between two of these points

Outline SquareOutline(Point2 center, double side) {
  const double h = side / 2, x = center.x, y = center.y;
  return {center, 0, {{x - h, y - h}, {x + h, y - h}, {x + h, y + h}, {x - h, y + h}}};
}

// `width` is the diameter, the side, or the distance between two flats, which face +-y.
Outline InnerOutline(InnerShape shape, Point2 center, double width) {
  if (shape == InnerShape::kCircle) return {center, width / 2, {}};
  if (shape == InnerShape::kSquare) return SquareOutline(center, width);
  const double corner = width / std::sqrt(3.0), h = width / 2, x = center.x, y = center.y;
  return {center,
          0,
          {{x - corner, y},
           {x - corner / 2, y - h},
           {x + corner / 2, y - h},
           {x + corner, y},
           {x + corner / 2, y + h},
           {x - corner / 2, y + h}}};
}

// A Catmull-Rom curve through the butterfly's points.
Polygon ButterflyPolygon(double side) {
  const int half = static_cast<int>(std::size(kButterflyHalf));
  const int count = 2 * half - 2;
  const auto knot = [&](int i) {
    const int k = (i + count) % count;
    const Point2 p = kButterflyHalf[k < half ? k : count - k];
    return k < half ? p : Point2{-p.x, p.y};
  };
  Polygon polygon;
  for (int i = 0; i < count; ++i) {
    const Point2 a = knot(i - 1), b = knot(i), c = knot(i + 1), d = knot(i + 2);
    for (int step = 0; step < kButterflySteps; ++step) {
      const double t = static_cast<double>(step) / kButterflySteps;
      const auto blend = [t](double p, double q, double r, double s) {
        return q + t / 2 * (r - p + t * (2 * p - 5 * q + 4 * r - s + t * (3 * (q - r) + s - p)));
      };
      polygon.push_back({side * blend(a.x, b.x, c.x, d.x), side * blend(a.y, b.y, c.y, d.y)});
    }
  }
  return polygon;
}

// The user's polygon in positive orientation, without a repeated closing point.
Polygon CheckedPolygon(Polygon polygon) {
  if (polygon.size() > 1 && polygon.front() == polygon.back()) polygon.pop_back();
  if (polygon.size() < 3) {
    FailArgument("polygon has " + std::to_string(polygon.size()) +
                 " points: at least 3 are needed");
  }
  if (polygon.size() > kMaxPolygonPoints) {
    FailArgument("polygon has " + std::to_string(polygon.size()) + " points: at most " +
                 std::to_string(kMaxPolygonPoints) + " are allowed");
  }
  for (const Point2& p : polygon) {
    // Written so that NaN fails too.
    if (!(std::abs(p.x) <= kMaxLength && std::abs(p.y) <= kMaxLength)) {
      FailArgument("polygon point (" + Text(p.x) + ", " + Text(p.y) + ") is not within +-" +
                   Text(kMaxLength) + " units");
    }
  }
  if (!IsSimple(polygon))
    FailArgument("polygon is not simple: its outline touches or crosses itself");
  if (SignedArea(polygon) < 0) std::reverse(polygon.begin(), polygon.end());
  return polygon;
}

void CheckClearance(const Polygon& polygon, const std::vector<std::vector<Outline>>& nodes) {
  for (const auto& node : nodes) {
    for (const Outline& outline : node) {
      const std::string where =
          "the node at (" + Text(outline.center.x) + ", " + Text(outline.center.y) + ")";
      if (!Contains(polygon, outline.center)) FailArgument("polygon does not contain " + where);
      const double clearance = outline.radius > 0
                                   ? DistanceToOutline(polygon, outline.center) - outline.radius
                                   : DistanceBetween(polygon, outline.points);
      if (clearance < kClearance - 1e-9) {
        FailArgument("polygon leaves " + Text(std::max(clearance, 0.0)) + " units around " + where +
                     ": at least " + Text(kClearance) + " is needed");
      }
    }
  }
}

Outline WhiteOutline(const MarkerDesign& design) {
  const double side = design.family.white_side();
  switch (design.outer) {
    case OuterShape::kSquare:
      return SquareOutline({0, 0}, side);
    case OuterShape::kCircle:
      return {{0, 0}, side / 2 * std::sqrt(2.0), {}};
    case OuterShape::kButterfly:
      return {{0, 0}, 0, ButterflyPolygon(side)};
    case OuterShape::kPolygon:
      break;
  }
  return {{0, 0}, 0, CheckedPolygon(design.polygon)};
}

Outline Widened(const Outline& outline, double width) {
  if (outline.radius > 0) return {outline.center, outline.radius + width, {}};
  return {outline.center, 0, OffsetOutwards(outline.points, width)};
}

void AddNodes(const MarkerDesign& design, MarkerGeometry* geometry) {
  const std::vector<Point2> vertices = ModelVertices(design.family);
  const auto node = [&](int v) { return InnerOutline(design.inner, vertices[v], kNodeWidth); };
  geometry->nodes.push_back({node(0), node(1)});
  for (int v = 0; v < design.family.vertex_count(); ++v) {
    if (v >= 2) geometry->nodes.push_back({node(v)});
    if (v < 2 || IdBit(design.family, design.id, v)) {
      geometry->holes.push_back(InnerOutline(design.inner, vertices[v], kHoleWidth));
    }
  }
}

void SetBounds(const Outline& outline, MarkerGeometry* geometry) {
  const double r = outline.radius;
  const Point2 c = outline.center;
  const Polygon extremes = r > 0 ? Polygon{{c.x - r, c.y - r}, {c.x + r, c.y + r}} : outline.points;
  geometry->min = geometry->max = extremes[0];
  for (const Point2& p : extremes) {
    geometry->min = {std::min(geometry->min.x, p.x), std::min(geometry->min.y, p.y)};
    geometry->max = {std::max(geometry->max.x, p.x), std::max(geometry->max.y, p.y)};
  }
}

}  // namespace

InnerShape ParseInnerShape(const std::string& name) {
  for (const InnerShape shape : {InnerShape::kSquare, InnerShape::kCircle, InnerShape::kHexagon}) {
    if (name == Name(shape)) return shape;
  }
  FailArgument("unknown inner shape '" + name + "': expected one of square, circle, hexagon");
}

const char* Name(InnerShape shape) {
  switch (shape) {
    case InnerShape::kCircle:
      return "circle";
    case InnerShape::kHexagon:
      return "hexagon";
    case InnerShape::kSquare:
      break;
  }
  return "square";
}

const char* Name(OuterShape shape) {
  switch (shape) {
    case OuterShape::kCircle:
      return "circle";
    case OuterShape::kButterfly:
      return "butterfly";
    case OuterShape::kPolygon:
      return "polygon";
    case OuterShape::kSquare:
      break;
  }
  return "square";
}

MarkerGeometry BuildMarkerGeometry(const MarkerDesign& design) {
  if (design.id >= design.family.size()) {
    FailArgument("ID " + std::to_string(design.id) + " is out of range for family " +
                 design.family.name() + ": 0 .. " + std::to_string(design.family.size() - 1));
  }
  RequireEnum("inner shape", design.inner, InnerShape::kHexagon);
  RequireEnum("outer shape", design.outer, OuterShape::kPolygon);
  RequireRange("frame width", design.frame, 0, kMaxLength, "units");
  RequireRange("margin width", design.margin, 0, kMaxLength, "units");
  MarkerGeometry geometry;
  geometry.white = WhiteOutline(design);
  AddNodes(design, &geometry);
  if (design.outer == OuterShape::kPolygon) CheckClearance(geometry.white.points, geometry.nodes);
  if (design.frame > 0) geometry.frame.push_back(Widened(geometry.white, design.frame));
  if (design.margin > 0) {
    geometry.paper.push_back(Widened(geometry.white, design.frame + design.margin));
  }
  SetBounds(!geometry.paper.empty()   ? geometry.paper[0]
            : !geometry.frame.empty() ? geometry.frame[0]
                                      : geometry.white,
            &geometry);
  return geometry;
}

std::vector<Point2> Tessellate(const Outline& outline, int circle_segments) {
  if (!(outline.radius > 0)) return outline.points;
  if (circle_segments < 3 || circle_segments > 1000000) {
    FailArgument("a circle of " + std::to_string(circle_segments) + " sides");
  }
  const double step = 2 * M_PI / circle_segments;
  const double radius = outline.radius * std::sqrt(step / std::sin(step));
  Polygon polygon;
  for (int i = 0; i < circle_segments; ++i) {
    // From the top, so that the polygon mirrors itself left to right for any number of sides.
    polygon.push_back({outline.center.x + radius * std::sin(i * step),
                       outline.center.y - radius * std::cos(i * step)});
  }
  return polygon;
}

std::vector<Point2> TessellateUnion(const std::vector<Outline>& outlines, int circle_segments) {
  if (outlines.empty() || outlines.size() > 2) {
    FailArgument("a union of " + std::to_string(outlines.size()) + " outlines");
  }
  Polygon shape = Tessellate(outlines[0], circle_segments);
  if (outlines.size() == 1) return shape;
  // Each outline mirrors itself left to right: what the first one has left of the middle line,
  // and its mirror image, make up the union.
  const double middle = (outlines[0].center.x + outlines[1].center.x) / 2;
  const auto is_left = [&](size_t i) { return shape[i % shape.size()].x < middle; };
  size_t enter = 0;
  while (enter < shape.size() && (is_left(enter) || !is_left(enter + 1))) ++enter;
  if (enter == shape.size())
    FailArgument("outlines do not overlap: they have no union in one piece");
  const auto crossing = [&](size_t i) {
    const Point2 a = shape[i % shape.size()], b = shape[(i + 1) % shape.size()];
    return Point2{middle, a.y + (middle - a.x) / (b.x - a.x) * (b.y - a.y)};
  };
  Polygon whole{crossing(enter)};
  size_t i = enter + 1;
  for (; is_left(i); ++i) whole.push_back(shape[i % shape.size()]);
  whole.push_back(crossing(i - 1));
  for (size_t k = whole.size() - 2; k > 0; --k) {
    whole.push_back({2 * middle - whole[k].x, whole[k].y});
  }
  return whole;
}

}  // namespace topotag
