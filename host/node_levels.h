#ifndef TOPOTAG_HOST_NODE_LEVELS_H_
#define TOPOTAG_HOST_NODE_LEVELS_H_

#include "host/local_map.h"
#include "topotag/family.h"
#include "topotag/image.h"

namespace topotag {

/// Grey levels of a node: of the gap around it, with its change per unit of u and v, and of its
/// body. Single precision is a thousandth of what noise does to them.
struct NodeLevels {
  float white = 0;
  float white_u = 0, white_v = 0;
  float black = 0;
};

/// Nodes from this many pixels a square unit on are fine: the gradient of their gaps' white is
/// trusted, not only its level (host/shading.h), and there is room for three outlines in the gap.
inline constexpr double kFineArea = 64;

/// Measures the means on the bodies' outlines, and least-squares planes on the gaps' outlines.
/// @param maps    of the points of ModelTable
/// @param levels  of the same points: of p1 and p2 the body only, last the baseline node as a whole
/// @param holes   grey levels at the vertices
/// @return false where a node is too large for a number of 32 bits or nowhere near the image.
bool MeasureLevels(const ImageView& image, Family family, const LocalMaps& maps, NodeLevels* levels,
                   float* holes);

}  // namespace topotag

#endif  // TOPOTAG_HOST_NODE_LEVELS_H_
