#ifndef TOPOTAG_HOST_BITS_H_
#define TOPOTAG_HOST_BITS_H_

#include "host/decode.h"
#include "topotag/image.h"

namespace topotag {

/// Confirms the bits of a decoded marker on the grey levels: a hole is brighter than the node
/// around it, a solid node is not. A hole that the bit image joined with the gap beside its node
/// is set; any other contradiction rejects the marker.
/// @return false where the marker is rejected.
bool ConfirmBits(const ImageView& image, Decoded* decoded);

}  // namespace topotag

#endif  // TOPOTAG_HOST_BITS_H_
