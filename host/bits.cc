#include "host/bits.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/sample.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

constexpr Point2 kBodyRing{1, 1};   // half sides of the square in the middle of the body, units
constexpr Point2 kGapRing{2, 2};    // the same of the gap
constexpr double kMinContrast = 6;  // of the gap to the body, grey levels
// Holes and solid nodes must differ by this much of the contrast; two nodes of the same kind differ
// by less than half of it.
constexpr double kMinSpread = 0.2;
// The darkest of all nodes with holes, in parts of the baseline node's.
constexpr double kMinOpen = 0.15;
// A node this near to the middle between both kinds, in parts of their difference, is neither.
constexpr double kUndecided = 0.15;

// Brightness of the centre over that of the body around it, in parts of the contrast.
double Hole(const ImageView& image, const LocalMap& map, double contrast) {
  return (Bilinear(image, map.center) - RingLevel(image, map, kBodyRing)) / contrast;
}

// Gap minus body.
double Contrast(const ImageView& image, const LocalMap& map) {
  return RingLevel(image, map, kGapRing) - RingLevel(image, map, kBodyRing);
}

}  // namespace

bool ConfirmBits(const ImageView& image, Decoded* decoded) {
  const Family family = decoded->family;
  const int count = family.vertex_count();
  std::array<double, kMaxVertices> hole;
  double solid = INFINITY;
  double mean_contrast = 0;
  for (int i = 2; i < count; ++i) {
    const LocalMap map(decoded->map, ModelVertex(family, i));
    const double contrast = Contrast(image, map);
    if (!(contrast > kMinContrast)) return false;
    hole[static_cast<size_t>(i)] = Hole(image, map, contrast);
    solid = std::min(solid, hole[static_cast<size_t>(i)]);
    mean_contrast += contrast / (count - 2);
  }
  double open = 0;
  for (int i = 0; i < 2; ++i) {
    open += Hole(image, LocalMap(decoded->map, ModelVertex(family, i)), mean_contrast) / 2;
  }
  const double spread = open - solid;
  const bool all_open = decoded->id == family.size() - 1;
  if (all_open && solid > kMinOpen * open) return true;  // there is no solid node to compare with
  if (!(spread > kMinSpread)) return false;

  uint64_t bits = 0;
  for (int i = 2; i < count; ++i) {
    const double from_middle = (hole[static_cast<size_t>(i)] - solid) / spread - 0.5;
    if (std::abs(from_middle) < kUndecided) return false;
    bits |= static_cast<uint64_t>(from_middle > 0) << i;
  }
  decoded->id = IdFromVertexBits(family, bits);
  return true;
}

}  // namespace topotag
