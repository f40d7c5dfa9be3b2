#ifndef TOPOTAG_HOST_PARTIAL_H_
#define TOPOTAG_HOST_PARTIAL_H_

#include <vector>

#include "host/decode.h"
#include "host/tree.h"
#include "topotag/image.h"

namespace topotag {

/// Reads a marker whose topology something in the frame has broken: an occluder that covers a part
/// of it, or only touches its nodes; a spot that joins two of them or cuts one in pieces; a white
/// area that runs out into its surroundings. Paper: section 4.2, error correction, which takes away
/// small components; here nodes are found by where the grid of the others expects them.
///
/// The whole nodes are grown to a lattice, without regard to what surrounds them; the grey levels
/// of its cells then say where it goes on, where the baseline node is, and which bit each node has.
/// A bit counts only where the centre of its node is seen for certain: between parts of the node's
/// own outline on opposite sides. Nodes of which that is not so are hidden.
/// @param families      sorted
/// @param nodes         of the labelled image, in any order; those that belong to no grid too
/// @param start         pixel of the frame near which grids are looked for first
/// @param hidden_nodes  that a marker may have
/// @param decoded       on success, what Decode and ConfirmBits tell, with hidden and unmeasured
/// @return false where no marker is read.
bool ReadPartial(const ImageView& image, const std::vector<Family>& families, const Node* nodes,
                 int count, const Camera* camera, const SearchArea& area, Point2 start,
                 int hidden_nodes, Decoded* decoded);

}  // namespace topotag

#endif  // TOPOTAG_HOST_PARTIAL_H_
