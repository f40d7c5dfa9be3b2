#ifndef TOPOTAG_HOST_JPEG_H_
#define TOPOTAG_HOST_JPEG_H_

#include <cstdint>
#include <vector>

#include "topotag/image.h"

namespace topotag {

/// Decodes the luminance of a JPEG file. Unlike OpenCV's decoder it prints nothing, and where
/// libjpeg notices damage that is an error, not a picture with parts made up.
/// @throws Error with the reason only: (kFile) damage; CheckImageSize's, before
///         memory is asked for.
Image DecodeJpeg(const std::vector<uint8_t>& bytes, uint64_t max_pixels);

}  // namespace topotag

#endif  // TOPOTAG_HOST_JPEG_H_
