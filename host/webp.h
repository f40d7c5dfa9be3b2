#ifndef TOPOTAG_HOST_WEBP_H_
#define TOPOTAG_HOST_WEBP_H_

#include <cstdint>
#include <vector>

#include "topotag/image.h"

namespace topotag {

/// Decodes the luminance of a WebP file whose size is checked. Not by OpenCV, which hands a file
/// with a damaged header on to whatever decoder takes some other bytes of it for its own.
/// @throws Error (kFile) with the reason only.
Image DecodeWebp(const std::vector<uint8_t>& bytes);

}  // namespace topotag

#endif  // TOPOTAG_HOST_WEBP_H_
