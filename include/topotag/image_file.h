#ifndef TOPOTAG_IMAGE_FILE_H_
#define TOPOTAG_IMAGE_FILE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "topotag/image.h"

namespace topotag {

/// Pixels of the largest image that is read unless the caller says otherwise.
inline constexpr uint64_t kDefaultMaxPixels = uint64_t{1} << 28;

/// Reads a PNG, JPEG, BMP, PNM, TIFF or WebP file, told by its content, as 8-bit luminance.
/// 16-bit images are scaled down with rounding (PNM: by their maximum value), colour is converted
/// (Rec. 601), alpha is ignored. TIFF files of many pages give their first. An orientation tag is
/// not applied: the pixels stay in the order in which the sensor, and its calibration, see them.
/// No memory is asked for the pixels of an image that has more than `max_pixels`.
/// @throws Error (kFile: missing, empty, truncated, corrupt, not an image, floating-point pixels,
///         an animated WebP, sides above kMaxImageSide; kTooLarge), naming the file and the reason.
Image ReadImage(const std::string& path, uint64_t max_pixels = kDefaultMaxPixels);

/// Writes the format of the extension, in any case: .png .jpg .jpeg .bmp .pgm .ppm .pnm .tif
/// .tiff .webp; to a temporary name in the same folder first, then renamed.
/// @throws Error (kInvalidArgument) for an invalid view, (kFile) naming the path and the reason.
void WriteImage(const ImageView& image, const std::string& path);

/// Paths of the files in a folder with one of WriteImage's extensions, sorted by name (bytes).
/// Hidden files are left out, sub-folders are not entered.
/// @throws Error (kFile) where the folder cannot be read or holds no image.
std::vector<std::string> ListImages(const std::string& folder);

}  // namespace topotag

#endif  // TOPOTAG_IMAGE_FILE_H_
