#ifndef TOPOTAG_HOST_WEBP_H_
#define TOPOTAG_HOST_WEBP_H_

#include <cstdint>
#include <vector>

#include "topotag/image.h"

namespace topotag {

/// Decodes the luminance of a WebP file. Not by OpenCV, which hands a file with a damaged header on
/// to whatever decoder takes some other bytes of it for its own.
/// @throws Error with the reason only: (kFile) damage, an animation; CheckImageSize's,
///         before memory is asked for.
Image DecodeWebp(const std::vector<uint8_t>& bytes, uint64_t max_pixels);

}  // namespace topotag

#endif  // TOPOTAG_HOST_WEBP_H_
