#include "host/search_plan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "host/pipeline.h"

namespace topotag {
namespace {

constexpr int kWordPixels = 64;
// What a region takes beyond its markers and its pixels, in pixels of an empty wall; and the part
// of the area from which on regions are no faster than all of it.
constexpr int64_t kRegionCost = 1 << 15;
constexpr double kMaxShare = 0.75;

bool Touches(const Rect& a, const Rect& b) {
  return a.x <= b.x + b.width && b.x <= a.x + a.width && a.y <= b.y + b.height &&
         b.y <= a.y + a.height;
}

Rect Union(const Rect& a, const Rect& b) {
  const int x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x,
          std::max(a.y + a.height, b.y + b.height) - y};
}

// [lo, hi] on one axis, rounded out to multiples of `step` from `first` on, within `count` pixels.
// False where nothing is left, or where it is not finite.
bool Span(double lo, double hi, int first, int count, int step, int* begin, int* size) {
  if (!(hi >= first && lo <= first + count - 1)) return false;
  const double from = std::max(lo - first, 0.0);
  const double to = std::min(hi - first, static_cast<double>(count - 1));
  const int start = static_cast<int>(from) / step * step;
  const int end = std::min((static_cast<int>(to) / step + 1) * step, count);
  *begin = first + start;
  *size = end - start;
  return true;
}

bool RegionOf(const Expectation& e, const Rect& area, Rect* region) {
  // A marker that is expected wholly outside has left, however wide the margin.
  if (!(e.max_x >= area.x && e.min_x <= area.x + area.width - 1 && e.max_y >= area.y &&
        e.min_y <= area.y + area.height - 1)) {
    return false;
  }
  return Span(e.min_x - e.margin, e.max_x + e.margin, area.x, area.width, kWordPixels, &region->x,
              &region->width) &&
         Span(e.min_y - e.margin, e.max_y + e.margin, area.y, area.height, kTile, &region->y,
              &region->height);
}

// Adds a region; those that it touches become one with it.
void AddRegion(Rect region, std::vector<Rect>* regions) {
  for (size_t i = 0; i < regions->size();) {
    Rect& other = (*regions)[i];
    if (!Touches(region, other)) {
      ++i;
      continue;
    }
    region = Union(region, other);
    other = regions->back();
    regions->pop_back();
    i = 0;
  }
  regions->push_back(region);
}

}  // namespace

bool PlanRegions(const std::vector<Track>& tracks, const Rect& area, std::vector<Rect>* regions) {
  regions->clear();
  const auto limit = static_cast<int64_t>(kMaxShare * area.width * area.height);
  const auto is_worth_it = [&] {
    int64_t cost = 0;
    for (const Rect& region : *regions) {
      cost += kRegionCost + int64_t{region.width} * region.height;
    }
    return cost <= limit;
  };
  for (const Track& track : tracks) {
    Rect region;
    if (RegionOf(Expect(track), area, &region)) {
      AddRegion(region, regions);
      if (is_worth_it()) continue;
    }
    regions->clear();
    return false;
  }
  return !regions->empty();
}

bool IsInside(const Detection& detection, const Rect& region, const Rect& area) {
  const int right = region.x + region.width, bottom = region.y + region.height;
  const double min_x = region.x == area.x ? -INFINITY : region.x + kTile;
  const double min_y = region.y == area.y ? -INFINITY : region.y + kTile;
  const double max_x = right == area.x + area.width ? INFINITY : right - 1 - kTile;
  const double max_y = bottom == area.y + area.height ? INFINITY : bottom - 1 - kTile;
  return std::all_of(detection.corners.begin(), detection.corners.end(), [&](const Point2& corner) {
    return corner.x >= min_x && corner.x <= max_x && corner.y >= min_y && corner.y <= max_y;
  });
}

}  // namespace topotag
