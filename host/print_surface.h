#ifndef TOPOTAG_HOST_PRINT_SURFACE_H_
#define TOPOTAG_HOST_PRINT_SURFACE_H_

#include <memory>
#include <string>
#include <vector>

#include "topotag/marker.h"

namespace topotag {

enum class PrintFormat { kPng, kSvg, kPdf };

/// By the extension, in either case.
/// @throws Error (kFile) that names the path and the extensions.
PrintFormat PrintFormatOf(const std::string& path);

/// Pages to draw on. Coordinates: millimetres, (0, 0) = top-left corner, x right, y down.
/// grey: 0 = black, 1 = white.
class PrintSurface {
 public:
  virtual ~PrintSurface() = default;
  PrintSurface(const PrintSurface&) = delete;
  PrintSurface& operator=(const PrintSurface&) = delete;

  /// Size of a page, in a PNG of its whole pixels.
  double width_mm() const { return width_mm_; }
  double height_mm() const { return height_mm_; }

  /// Fills the union of the outlines, which all turn the same way.
  virtual void Fill(const std::vector<Outline>& outlines, double grey) = 0;
  /// Draws open lines with round ends.
  virtual void Stroke(const std::vector<std::vector<Point2>>& lines, double line_width,
                      double grey) = 0;
  /// PDF only.
  virtual void NextPage() = 0;
  /// The nearest place where edges on a grid of `unit_mm` are crisp: a pixel corner in a PNG
  /// whose pixels divide the unit; elsewhere `point` itself.
  virtual Point2 Aligned(Point2 point, double unit_mm) const = 0;
  /// The file's bytes. Nothing may be drawn after it.
  virtual std::string Finish() = 0;

 protected:
  PrintSurface(double width_mm, double height_mm) : width_mm_(width_mm), height_mm_(height_mm) {}

 private:
  double width_mm_;
  double height_mm_;
};

/// dpi: PNG only; already checked, as the size is.
/// @throws Error (kInvalidArgument) where a PNG would be wider or higher than kMaxImageSide.
std::unique_ptr<PrintSurface> MakePrintSurface(PrintFormat format, double width_mm,
                                               double height_mm, double dpi);

}  // namespace topotag

#endif  // TOPOTAG_HOST_PRINT_SURFACE_H_
