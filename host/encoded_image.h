#ifndef TOPOTAG_HOST_ENCODED_IMAGE_H_
#define TOPOTAG_HOST_ENCODED_IMAGE_H_

#include <cstdint>
#include <vector>

#include "topotag/image.h"
#include "topotag/image_file.h"

namespace topotag {

enum class ImageFormat { kPng, kJpeg, kBmp, kPnm, kTiff, kWebp };

/// @throws Error with the reason only: (kFile) no pixels, sides above kMaxImageSide; (kTooLarge)
///         more than `max_pixels` pixels.
void CheckImageSize(uint64_t width, uint64_t height, uint64_t max_pixels);

/// Checks the bytes of an image file before a decoder sees them: decoders print to stderr, fill
/// what is missing with grey, and allocate whatever size a header claims. The sizes of JPEG and
/// WebP files are left to DecodeJpeg and DecodeWebp, which check what the decoders themselves read.
/// PNG chunks that do not change the pixels are removed from `bytes`.
/// @throws Error with the reason only: (kFile) not an image of these formats, truncated, corrupt;
///         CheckImageSize's.
ImageFormat CheckEncodedImage(std::vector<uint8_t>* bytes, uint64_t max_pixels = kDefaultMaxPixels);

/// Decodes a checked PNM file (P1 .. P6, any maximum value) to 8-bit luminance.
Image DecodePnm(const std::vector<uint8_t>& bytes);

/// Decodes an image file to 8-bit luminance, as ReadImage does.
/// @throws Error with the reason only: CheckEncodedImage's, or (kFile) the decoder's.
Image DecodeImage(std::vector<uint8_t> bytes, uint64_t max_pixels = kDefaultMaxPixels);

/// Rec. 601 luminance of a pixel whose white is `max`, rounded to nearest, 0 .. 255.
inline uint8_t Luminance(uint64_t r, uint64_t g, uint64_t b, uint64_t max) {
  return static_cast<uint8_t>(((299 * r + 587 * g + 114 * b) * 255 + 500 * max) / (1000 * max));
}

}  // namespace topotag

#endif  // TOPOTAG_HOST_ENCODED_IMAGE_H_
