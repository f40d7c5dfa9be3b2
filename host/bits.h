#ifndef TOPOTAG_HOST_BITS_H_
#define TOPOTAG_HOST_BITS_H_

#include "host/decode.h"
#include "topotag/image.h"

namespace topotag {

/// Confirms the bits of a decoded marker on the grey levels. How bright a hole is, and how dark a
/// solid node, depends on size, tilt and blur; but within one marker the nodes of each kind, the
/// two holes of the baseline node among them, look alike where the resolution is the same. Every
/// node must belong clearly to one kind. Where that contradicts the topology (a hole that the bit
/// image closed, or joined with the gap beside its node), the grey levels decide.
/// @return false where the marker is rejected.
bool ConfirmBits(const ImageView& image, Decoded* decoded);

}  // namespace topotag

#endif  // TOPOTAG_HOST_BITS_H_
