#include "host/far_outline.h"

#include <algorithm>
#include <cmath>

namespace topotag {
namespace {

constexpr double kMinCover = 0.85;  // of the hull by the quadrilateral
constexpr size_t kMaxHull = 200;

double Cross(Point2 a, Point2 b, Point2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Appends the convex chain through points that are in order along it.
void AddChain(const std::vector<Point2>& points, std::vector<Point2>* hull) {
  const size_t begin = hull->size();
  for (const Point2& p : points) {
    while (hull->size() >= begin + 2 && Cross((*hull)[hull->size() - 2], hull->back(), p) <= 0) {
      hull->pop_back();
    }
    hull->push_back(p);
  }
}

double Area(const std::vector<Point2>& polygon) {
  double sum = 0;
  for (size_t i = 2; i < polygon.size(); ++i) {
    sum += Cross(polygon[0], polygon[i - 1], polygon[i]);
  }
  return sum / 2;
}

// The largest quadrilateral with corners among the hull's.
double LargestQuad(const std::vector<Point2>& hull, Point2 quad[4]) {
  double best = 0;
  for (size_t i = 0; i < hull.size(); ++i) {
    size_t right = i + 1;
    size_t left = i + 3;
    for (size_t k = i + 2; k + 1 < hull.size(); ++k) {
      const auto area = [&](size_t m) { return std::abs(Cross(hull[i], hull[k], hull[m])); };
      while (right + 1 < k && area(right + 1) > area(right)) ++right;
      left = std::max(left, k + 1);
      while (left + 1 < hull.size() && area(left + 1) > area(left)) ++left;
      const double sum = (area(right) + area(left)) / 2;
      if (sum <= best) continue;
      best = sum;
      quad[0] = hull[i];
      quad[1] = hull[right];
      quad[2] = hull[k];
      quad[3] = hull[left];
    }
  }
  return best;
}

}  // namespace

bool FarOutline::Find(const Components& components, uint32_t root, const Feature& white,
                      Point2 quad[4]) {
  points_.clear();
  hull_.clear();
  // Down the right side, then up the left one.
  const auto add = [&](int y, bool right) {
    const uint32_t first = components.row_begin[static_cast<size_t>(y)];
    const uint32_t runs = components.row_runs[static_cast<size_t>(y)];
    for (uint32_t i = 0; i < runs; ++i) {
      const uint32_t run = first + (right ? runs - 1 - i : i);
      if (components.root[components.label[run]] != root) continue;
      points_.push_back({components.bound[run + right] - 0.5, static_cast<double>(y)});
      return;
    }
  };
  for (int y = white.min_y; y <= white.max_y; ++y) add(y, true);
  AddChain(points_, &hull_);
  points_.clear();
  for (int y = white.max_y; y >= white.min_y; --y) add(y, false);
  AddChain(points_, &hull_);
  if (hull_.size() < 4 || hull_.size() > kMaxHull) return false;
  return LargestQuad(hull_, quad) > kMinCover * Area(hull_);
}

}  // namespace topotag
