#ifndef TOPOTAG_HOST_BITS_H_
#define TOPOTAG_HOST_BITS_H_

#include "host/decode.h"
#include "topotag/image.h"

namespace topotag {

/// Confirms the bits of a decoded marker on the grey levels. How bright a hole is, and how dark a
/// solid node, depends on size, tilt and blur; but within one marker the two holes of the baseline
/// node show the one, its darkest node the other. Every node must belong clearly to one of them.
/// Where that contradicts the topology (a hole that the bit image joined with the gap beside its
/// node, or closed), the grey levels decide.
/// @return false where the marker is rejected.
bool ConfirmBits(const ImageView& image, Decoded* decoded);

}  // namespace topotag

#endif  // TOPOTAG_HOST_BITS_H_
