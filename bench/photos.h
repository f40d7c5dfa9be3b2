#ifndef TOPOTAG_BENCH_PHOTOS_H_
#define TOPOTAG_BENCH_PHOTOS_H_

#include <string>
#include <vector>

#include "topotag/image.h"

namespace topotag::bench {

/// Backgrounds of the cluttered scenes.
struct Photos {
  std::vector<Image> images;
  std::string source;  ///< for the report: where they come from
};

/// Photographs of a folder, spread evenly over it, as many as a mosaic can use; without small
/// ones. For an empty name, or in a build without files: procedural clutter, equal everywhere.
/// @throws Error (kFile) where the folder cannot be read or holds no photograph of use;
///         (kUnavailable) where it is named in a build without files.
Photos LoadPhotos(const std::string& folder);

/// The one whose texture (mean difference of neighbours) is the median of all.
const Image& TypicalPhoto(const Photos& photos);

/// Photographs side by side, each scaled to cover a tile of 320 x 240.
Image Mosaic(const Photos& photos, int width, int height);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_PHOTOS_H_
