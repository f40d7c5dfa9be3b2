#ifndef TOPOTAG_GENERATOR_H_
#define TOPOTAG_GENERATOR_H_

#include <string>
#include <vector>

#include "topotag/marker.h"

namespace topotag {

/// Print size. Exact in SVG and PDF; a PNG carries its resolution (pHYs) and its side is rounded
/// to whole pixels.
struct PrintOptions {
  double size_mm = 50;  ///< side of the white area (4n+1 units), millimetres
  double dpi = 300;     ///< PNG only
};

/// Writes one marker: white area, frame and margin, nothing more. The format follows the
/// extension: .png, .svg, .pdf. Written to a temporary name first, so that a failure leaves no
/// half-written file.
/// @throws Error (kInvalidArgument: design or size; kFile: extension or a path that cannot be
///         written), naming the value or path.
void WriteMarker(const MarkerDesign& design, const PrintOptions& print, const std::string& path);

struct SheetOptions {
  double page_width_mm = 210;
  double page_height_mm = 297;
  double page_margin_mm = 10;
  double gap_mm = 8;  ///< between markers; the label stands in it
};

/// Writes a printable sheet with a label (family and ID) below each marker: a PDF of as many
/// pages as needed; PNG or SVG hold one page.
/// @throws Error as WriteMarker; kInvalidArgument also where a marker does not fit the page or
///         the markers do not fit one page of PNG or SVG.
void WriteSheet(const std::vector<MarkerDesign>& designs, const PrintOptions& print,
                const SheetOptions& sheet, const std::string& path);

}  // namespace topotag

#endif  // TOPOTAG_GENERATOR_H_
