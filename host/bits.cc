#include "host/bits.h"

#include "host/sample.h"

namespace topotag {
namespace {

// Brightness of a node's centre over that of its body, in parts of the gap's over the body's.
// Solid nodes were seen between -0.1 and 0.05, holes of 1.4 px at 0.6, larger ones at 0.9 to 1.1.
constexpr double kHole = 0.35;
constexpr double kSolid = 0.15;
constexpr Point2 kBodyRing{1, 1};   // half sides of the square in the middle of the body, units
constexpr Point2 kGapRing{2, 2};    // the same of the gap
constexpr double kMinContrast = 6;  // grey levels

}  // namespace

bool ConfirmBits(const ImageView& image, Decoded* decoded) {
  const int n = decoded->family.n();
  for (int i = 2; i < n * n; ++i) {
    const LocalMap map(decoded->map, ModelVertex(n, i));
    const double body = RingLevel(image, map, kBodyRing);
    const double contrast = RingLevel(image, map, kGapRing) - body;
    if (!(contrast > kMinContrast)) return false;
    const double center = (Bilinear(image, map.center) - body) / contrast;
    const uint64_t bit = uint64_t{1} << (n * n - 1 - i);
    if ((decoded->id & bit) == 0) {
      if (center >= kHole) {
        decoded->id |= bit;
      } else if (center > kSolid) {
        return false;
      }
    } else if (center < kSolid) {
      return false;
    }
  }
  return true;
}

}  // namespace topotag
