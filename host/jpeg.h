#ifndef TOPOTAG_HOST_JPEG_H_
#define TOPOTAG_HOST_JPEG_H_

#include <cstdint>
#include <vector>

#include "topotag/image.h"

namespace topotag {

/// Decodes the luminance of a JPEG file whose size is checked. Unlike OpenCV's decoder it prints
/// nothing, and where libjpeg notices damage that is an error, not a picture with parts made up.
/// @throws Error (kFile) with the reason only.
Image DecodeJpeg(const std::vector<uint8_t>& bytes);

}  // namespace topotag

#endif  // TOPOTAG_HOST_JPEG_H_
