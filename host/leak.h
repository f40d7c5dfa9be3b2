#ifndef TOPOTAG_HOST_LEAK_H_
#define TOPOTAG_HOST_LEAK_H_

#include "host/decode.h"
#include "host/support.h"
#include "topotag/image.h"

namespace topotag {

/// First moments of the darkness that blur carries into the supports of small nodes from beyond
/// their gaps: from neighbours on inner sides, from all along the frame on outer ones, from nothing
/// next to the baseline node. A node's centroid is off by its moment over its own darkness.
///
/// Point spread function and pixel are taken as one Gaussian, whose width follows from how bright
/// holes still are beside gaps; the darkness of the frame is measured. What lies further away than
/// one gap does not count.
/// @param maps        at the centres of the targets
/// @param supports    of the targets; their white is not used
/// @param vertex      of the targets: vertices from 2 on, vertex_count() for the baseline node
/// @param squareness  of the nodes, 0 for round ones .. 1 for square ones, as their corners say
/// @param leak        of the targets: over u and v in units, of the darkness relative to the white
///                    around the target
/// @return false where nodes are so large that nothing counts, or no hole is seen: then nothing
///         is set.
bool FindLeaks(const ImageView& image, const Decoded& decoded, const LocalMaps& maps,
               const Supports& supports, const int* vertex, int count, double* squareness,
               Point2* leak);

}  // namespace topotag

#endif  // TOPOTAG_HOST_LEAK_H_
