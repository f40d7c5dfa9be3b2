#ifndef TOPOTAG_IMAGE_FILE_H_
#define TOPOTAG_IMAGE_FILE_H_

#include <string>
#include <vector>

#include "topotag/image.h"

namespace topotag {

/// Reads an image as 8-bit luminance. 16-bit images are scaled down, colour is converted
/// (Rec. 601), alpha is ignored. Multi-frame files give their first frame.
/// @throws Error (kFile: missing, empty, truncated, not an image, larger than kMaxImageSide),
///         naming the file and the reason.
Image ReadImage(const std::string& path);

/// Writes PNG or another format by extension; to a temporary name first, then renamed.
/// @throws Error (kFile) that names the path.
void WriteImage(const ImageView& image, const std::string& path);

/// Paths of the image files in a folder, sorted by name; sub-folders are not entered.
/// @throws Error (kFile) where the folder cannot be read or holds no image.
std::vector<std::string> ListImages(const std::string& folder);

}  // namespace topotag

#endif  // TOPOTAG_IMAGE_FILE_H_
