#include "topotag/generator.h"

#include <algorithm>
#include <cmath>

#include "host/check.h"
#include "host/file.h"
#include "host/print_surface.h"

namespace topotag {
namespace {

constexpr double kBlack = 0;
constexpr double kWhite = 1;
constexpr double kCutMarkGrey = 0.6;
constexpr double kCutMarkWidthMm = 0.1;
constexpr double kMaxCutMarkMm = 3;
constexpr double kMaxLabelMm = 3;
// The largest page that PDF readers show is 200 inches.
constexpr double kMinSizeMm = 1;
constexpr double kMaxSizeMm = 5000;
constexpr double kMinDpi = 1;
constexpr double kMaxDpi = 100000;

// The label's characters as strokes, so that no font is needed and every machine draws the same
// bytes. Each pair of digits is a point on a grid 5 wide and 7 high, y down; '|' lifts the pen.
constexpr double kGlyphHeight = 6;
constexpr double kGlyphAdvance = 6;
struct Glyph {
  char character;
  const char* strokes;
};
constexpr Glyph kGlyphs[] = {{'0', "103041453616050110"},
                             {'1', "112026|1636"},
                             {'2', "01103041420646"},
                             {'3', "004022324345361605"},
                             {'4', "36300444"},
                             {'5', "400002324345361605"},
                             {'6', "30200205163645443303"},
                             {'7', "004016"},
                             {'8', "13020110304142331304051636454433"},
                             {'9', "16264441301001021343"},
                             {'x', "0246|4206"},
                             {'m', "0602|03122326|23324346"},
                             {'.', "2526"}};

// A marker's geometry with its size on paper.
struct Print {
  Print(const MarkerDesign& design, const PrintOptions& print, PrintFormat format)
      : geometry(BuildMarkerGeometry(design)),
        white(design.inverted ? kBlack : kWhite),
        black(design.inverted ? kWhite : kBlack) {
    RequireRange("size", print.size_mm, kMinSizeMm, kMaxSizeMm, "mm");
    unit = print.size_mm / design.family.white_side();
    width = unit * (geometry.max.x - geometry.min.x);
    height = unit * (geometry.max.y - geometry.min.y);
    RequireRange("picture width", width, 0, kMaxSizeMm, "mm");
    RequireRange("picture height", height, 0, kMaxSizeMm, "mm");
    if (format != PrintFormat::kPng) return;
    RequireRange("resolution", print.dpi, kMinDpi, kMaxDpi, "dpi");
    const double pixels = unit * print.dpi / 25.4;
    if (pixels < 1) {
      FailArgument("a unit of " + Text(pixels) + " px is too small to draw (size " +
                   Text(print.size_mm) + " mm at " + Text(print.dpi) + " dpi, family " +
                   design.family.name() + "): at least 1 px is needed");
    }
  }

  MarkerGeometry geometry;
  double white, black;         // greys of what they are on a marker that is not inverted
  double unit, width, height;  // mm
};

// Draws a marker with the top-left corner of its bounding box at `corner`.
void DrawMarker(const Print& print, Point2 corner, PrintSurface* surface) {
  const double unit = print.unit;
  const MarkerGeometry& geometry = print.geometry;
  // All straight edges of nodes, holes and square frames lie half a unit off a whole one.
  const Point2 grid = surface->Aligned(
      {corner.x - unit * (geometry.min.x + 0.5), corner.y - unit * (geometry.min.y + 0.5)}, unit);
  const Point2 origin{grid.x + unit / 2, grid.y + unit / 2};
  const auto fill = [&](std::vector<Outline> outlines, double grey) {
    for (Outline& outline : outlines) {
      outline.center = {origin.x + unit * outline.center.x, origin.y + unit * outline.center.y};
      outline.radius *= unit;
      for (Point2& p : outline.points) p = {origin.x + unit * p.x, origin.y + unit * p.y};
    }
    if (!outlines.empty()) surface->Fill(outlines, grey);
  };
  fill(geometry.paper, print.white);
  fill(geometry.frame, print.black);
  fill({geometry.white}, print.white);
  for (const auto& node : geometry.nodes) fill(node, print.black);
  for (const Outline& hole : geometry.holes) fill({hole}, print.white);
}

// Draws text centred on `middle`, in mm.
void DrawLabel(const std::string& text, Point2 middle, double height, PrintSurface* surface) {
  const double scale = height / kGlyphHeight;
  // The last character's advance ends with a gap of 2.
  const double left = middle.x - scale * (kGlyphAdvance * text.size() - 2) / 2;
  const double top = middle.y - height / 2;
  std::vector<std::vector<Point2>> lines;
  for (size_t i = 0; i < text.size(); ++i) {
    const double x = left + scale * kGlyphAdvance * i;
    for (const Glyph& glyph : kGlyphs) {
      if (glyph.character != text[i]) continue;
      lines.emplace_back();
      for (const char* p = glyph.strokes; *p != '\0'; p += *p == '|' ? 1 : 2) {
        if (*p == '|') {
          lines.emplace_back();
        } else {
          lines.back().push_back({x + scale * (p[0] - '0'), top + scale * (p[1] - '0')});
        }
      }
    }
  }
  surface->Stroke(lines, height / 8, kBlack);
}

// Short lines outside the corners of a marker's bounding box.
void DrawCutMarks(Point2 min, Point2 max, double gap, PrintSurface* surface) {
  const double length = std::min(kMaxCutMarkMm, 0.25 * gap), away = 0.15 * gap;
  std::vector<std::vector<Point2>> lines;
  for (const int sx : {-1, 1}) {
    for (const int sy : {-1, 1}) {
      const Point2 p{sx < 0 ? min.x : max.x, sy < 0 ? min.y : max.y};
      lines.push_back({{p.x + sx * away, p.y}, {p.x + sx * (away + length), p.y}});
      lines.push_back({{p.x, p.y + sy * away}, {p.x, p.y + sy * (away + length)}});
    }
  }
  surface->Stroke(lines, kCutMarkWidthMm, kCutMarkGrey);
}

void CheckSheet(const SheetOptions& sheet) {
  RequireRange("page width", sheet.page_width_mm, kMinSizeMm, kMaxSizeMm, "mm");
  RequireRange("page height", sheet.page_height_mm, kMinSizeMm, kMaxSizeMm, "mm");
  RequireRange("page margin", sheet.page_margin_mm, 0, kMaxSizeMm, "mm");
  RequireRange("gap", sheet.gap_mm, 0, kMaxSizeMm, "mm");
}

// A grid of equal cells, the largest marker in each, with the label's gap below every row.
struct SheetLayout {
  SheetLayout(const SheetOptions& sheet, double width, double height)
      : cell_width(width), cell_height(height), gap(sheet.gap_mm), top(sheet.page_margin_mm) {
    constexpr double kSlackMm = 1e-9;
    const double free_width = sheet.page_width_mm - 2 * sheet.page_margin_mm + kSlackMm;
    const double free_height = sheet.page_height_mm - 2 * sheet.page_margin_mm + kSlackMm;
    if (width > free_width || height + gap > free_height) {
      FailArgument("a marker of " + Text(width) + " x " + Text(height) + " mm with a gap of " +
                   Text(gap) + " mm below it does not fit a page of " + Text(sheet.page_width_mm) +
                   " x " + Text(sheet.page_height_mm) + " mm with margins of " +
                   Text(sheet.page_margin_mm) + " mm");
    }
    columns = static_cast<size_t>((free_width + gap) / (width + gap));
    rows = static_cast<size_t>(free_height / (height + gap));
    left = (sheet.page_width_mm - columns * (width + gap) + gap) / 2;
  }

  Point2 CellCorner(size_t index) const {
    const size_t column = index % columns, row = index / columns % rows;
    return {left + static_cast<double>(column) * (cell_width + gap),
            top + static_cast<double>(row) * (cell_height + gap)};
  }

  double cell_width, cell_height, gap, top, left;
  size_t columns, rows;
};

void DrawCell(const MarkerDesign& design, const PrintOptions& options, PrintFormat format,
              Point2 cell, const SheetLayout& layout, PrintSurface* surface) {
  const Print print(design, options, format);
  const Point2 min{cell.x + (layout.cell_width - print.width) / 2,
                   cell.y + (layout.cell_height - print.height) / 2};
  const Point2 max{min.x + print.width, min.y + print.height};
  DrawMarker(print, min, surface);
  if (layout.gap <= 0) return;
  DrawCutMarks(min, max, layout.gap, surface);
  const std::string label =
      design.family.name() + " " + std::to_string(design.id) + "  " + Text(options.size_mm) + " mm";
  const double widest = 0.95 * print.width * kGlyphHeight / (kGlyphAdvance * label.size());
  DrawLabel(label, {(min.x + max.x) / 2, max.y + layout.gap / 2},
            std::min({kMaxLabelMm, 0.4 * layout.gap, widest}), surface);
}

void RequireOnePage(size_t markers, const SheetLayout& layout) {
  const size_t per_page = layout.columns * layout.rows;
  if (markers <= per_page) return;
  FailArgument(std::to_string(markers) + " markers need " +
               std::to_string((markers + per_page - 1) / per_page) +
               " pages: PNG and SVG hold one, PDF as many as needed");
}

}  // namespace

void WriteMarker(const MarkerDesign& design, const PrintOptions& options, const std::string& path) {
  const PrintFormat format = PrintFormatOf(path);
  const Print print(design, options, format);
  const auto surface = MakePrintSurface(format, print.width, print.height, options.dpi);
  // Centred where whole pixels make the page a little larger or smaller.
  DrawMarker(print,
             {(surface->width_mm() - print.width) / 2, (surface->height_mm() - print.height) / 2},
             surface.get());
  WriteWholeFile(path, surface->Finish());
}

void WriteSheet(const std::vector<MarkerDesign>& designs, const PrintOptions& options,
                const SheetOptions& sheet, const std::string& path) {
  const PrintFormat format = PrintFormatOf(path);
  CheckSheet(sheet);
  if (designs.empty()) FailArgument("a sheet needs at least one marker");
  double width = 0, height = 0;
  for (const MarkerDesign& design : designs) {
    const Print print(design, options, format);
    width = std::max(width, print.width);
    height = std::max(height, print.height);
    // At once: drawing a long list takes its time.
    if (format != PrintFormat::kPdf) {
      RequireOnePage(designs.size(), SheetLayout(sheet, width, height));
    }
  }
  const SheetLayout layout(sheet, width, height);
  const size_t per_page = layout.columns * layout.rows;
  const auto surface =
      MakePrintSurface(format, sheet.page_width_mm, sheet.page_height_mm, options.dpi);
  for (size_t i = 0; i < designs.size(); ++i) {
    if (i > 0 && i % per_page == 0) surface->NextPage();
    DrawCell(designs[i], options, format, layout.CellCorner(i), layout, surface.get());
  }
  WriteWholeFile(path, surface->Finish());
}

}  // namespace topotag
