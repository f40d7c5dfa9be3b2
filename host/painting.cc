#include "host/painting.h"

#include <algorithm>
#include <cmath>

#include "host/check.h"
#include "host/outline.h"

namespace topotag {
namespace {

// Of a hole, which is half a unit from its centre to its sides, and of half the gaps.
constexpr double kMaxGrowth = 0.4;

/// Every edge moved outwards by `distance`, or inwards where that is negative; corners are mitred.
Outline Moved(const Outline& outline, double distance) {
  Outline moved = outline;
  if (distance == 0) return moved;
  if (outline.radius > 0) {
    moved.radius += distance;
    return moved;
  }
  const Polygon& p = outline.points;
  const double outwards = SignedArea(p) > 0 ? distance : -distance;
  const auto normal = [&p](size_t from, size_t to) {
    const double dx = p[to].x - p[from].x, dy = p[to].y - p[from].y, length = std::hypot(dx, dy);
    return Point2{dy / length, -dx / length};
  };
  for (size_t i = 0; i < p.size(); ++i) {
    const Point2 a = normal((i + p.size() - 1) % p.size(), i), b = normal(i, (i + 1) % p.size());
    const double scale = outwards / (1 + a.x * b.x + a.y * b.y);
    moved.points[i] = {p[i].x + scale * (a.x + b.x), p[i].y + scale * (a.y + b.y)};
  }
  // Where an edge turns back on itself there is no mitre.
  const bool finite = std::all_of(moved.points.begin(), moved.points.end(), [](Point2 q) {
    return std::isfinite(q.x) && std::isfinite(q.y);
  });
  if (!finite || !IsSimple(moved.points)) {
    FailArgument("growth " + Text(std::abs(distance)) + " units: an outline crosses itself");
  }
  return moved;
}

std::vector<Outline> Moved(std::vector<Outline> outlines, double distance) {
  for (Outline& outline : outlines) outline = Moved(outline, distance);
  return outlines;
}

}  // namespace

Painting PaintMarker(const SceneMarker& marker) {
  const MarkerGeometry geometry = BuildMarkerGeometry(marker.design);
  // What is black on other markers is white on an inverted one, and shrinks where black grows.
  const bool inverted = marker.design.inverted;
  const double black = inverted ? marker.white : marker.black;
  const double white = inverted ? marker.black : marker.white;
  const double growth = inverted ? -marker.growth : marker.growth;
  RequireRange("growth", marker.growth, -kMaxGrowth, kMaxGrowth, "units");
  if (!geometry.frame.empty() && !(marker.design.frame + 2 * growth > 0)) {
    FailArgument("growth " + Text(marker.growth) + " units leaves nothing of the frame");
  }
  Painting painting;
  if (!geometry.paper.empty()) painting.push_back({geometry.paper, white, 0});
  // Without a frame there is no ink around the white area that could grow into it.
  const double into_white = geometry.frame.empty() ? 0 : -growth;
  if (!geometry.frame.empty()) painting.push_back({Moved(geometry.frame, growth), black, white});
  painting.push_back(
      {{Moved(geometry.white, into_white)}, white, geometry.frame.empty() ? white : black});
  for (const auto& node : geometry.nodes) painting.push_back({Moved(node, growth), black, white});
  for (const Outline& hole : geometry.holes) {
    painting.push_back({{Moved(hole, -growth)}, white, black});
  }
  return painting;
}

}  // namespace topotag
