#ifndef TOPOTAG_BENCH_PAPER_PNG_URI_H_
#define TOPOTAG_BENCH_PAPER_PNG_URI_H_

#include <string>

#include "topotag/image.h"

namespace topotag::bench::paper {

/// A grayscale PNG as "data:image/png;base64,..".
/// @throws Error (kFile) where libpng fails.
std::string PngUri(const ImageView& image);

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_PNG_URI_H_
