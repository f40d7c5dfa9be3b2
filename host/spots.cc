#include "host/spots.h"

#include <cmath>

namespace topotag {
namespace {

bool AddSpot(const Node& node, Point2 pixel, double area, const Camera* camera, Spots* spots) {
  if (spots->count == kMaxSpots) return false;
  Spot& spot = spots->spot[spots->count];
  if (!PixelToIdeal(camera, pixel, &spot.at)) return true;
  spot.area = area;
  if (TagMap{{}, camera}.HasLens()) {
    Point2 right, below;
    if (!PixelToIdeal(camera, {pixel.x + 1, pixel.y}, &right) ||
        !PixelToIdeal(camera, {pixel.x, pixel.y + 1}, &below)) {
      return true;
    }
    spot.area *= std::abs((right.x - spot.at.x) * (below.y - spot.at.y) -
                          (below.x - spot.at.x) * (right.y - spot.at.y));
  }
  spot.is_single = node.hole_count < 2;
  spots->node[spots->count++] = &node;
  return true;
}

}  // namespace

bool GatherSpots(const Node* nodes, int count, const Camera* camera, const SearchArea& area,
                 Spots* spots) {
  constexpr double kSinglePart = 9 / 15.0;  // of the baseline node's area
  for (int i = 0; i < count; ++i) {
    const Node& node = nodes[i];
    int64_t x = node.black.sum_x, y = node.black.sum_y;
    int64_t pixels = node.black.area;
    for (int k = 0; k < node.hole_count; ++k) {
      const Feature& hole = node.holes[static_cast<size_t>(k)];
      x += hole.sum_x;
      y += hole.sum_y;
      pixels += hole.area;
    }
    const double whole = static_cast<double>(pixels) / (area.scale * area.scale);
    if (node.hole_count == 2) {
      for (const Feature& hole : node.holes) {
        if (!AddSpot(node, area.CentroidInFrame(hole), kSinglePart * whole, camera, spots))
          return false;
      }
      continue;
    }
    if (!AddSpot(node, area.CentroidInFrame(x, y, pixels), whole, camera, spots)) return false;
  }
  return spots->count > 0;
}

}  // namespace topotag
