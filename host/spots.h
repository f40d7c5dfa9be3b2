#ifndef TOPOTAG_HOST_SPOTS_H_
#define TOPOTAG_HOST_SPOTS_H_

#include "host/decode.h"
#include "host/lattice.h"
#include "host/tree.h"

namespace topotag {

/// The spots of one place, and what the nodes that they come from are.
struct Spots {
  int count = 0;
  Spot spot[kMaxSpots];
  const Node* node[kMaxSpots];
};

/// One spot of each node; of one with two holes each hole: the baseline node's p1 lies on a
/// crossing of the grid, and so do the holes of two nodes that have run together.
/// @return false where there are none, or more than kMaxSpots.
bool GatherSpots(const Node* nodes, int count, const Camera* camera, const SearchArea& area,
                 Spots* spots);

}  // namespace topotag

#endif  // TOPOTAG_HOST_SPOTS_H_
