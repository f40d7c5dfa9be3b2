#include "host/print_surface.h"

#include <cairo-pdf.h>
#include <cairo.h>
#include <png.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <csetjmp>

#include "host/check.h"
#include "host/file.h"
#include "topotag/error.h"
#include "topotag/image.h"

namespace topotag {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;

struct CairoDelete {
  void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
  void operator()(cairo_t* c) const { cairo_destroy(c); }
};

// What PDF and PNG share: filled and stroked paths through cairo.
class CairoSurface : public PrintSurface {
 public:
  void Fill(const std::vector<Outline>& outlines, double grey) override {
    for (const Outline& outline : outlines) {
      cairo_new_sub_path(context_.get());
      if (outline.radius > 0) {
        cairo_arc(context_.get(), outline.center.x, outline.center.y, outline.radius, 0, 2 * M_PI);
      }
      for (const Point2& p : outline.points) cairo_line_to(context_.get(), p.x, p.y);
      cairo_close_path(context_.get());
    }
    SetGrey(grey);
    cairo_fill(context_.get());
  }

  void Stroke(const std::vector<std::vector<Point2>>& lines, double line_width,
              double grey) override {
    for (const auto& line : lines) {
      cairo_new_sub_path(context_.get());
      for (const Point2& p : line) cairo_line_to(context_.get(), p.x, p.y);
    }
    SetGrey(grey);
    cairo_set_line_width(context_.get(), line_width);
    cairo_set_line_cap(context_.get(), CAIRO_LINE_CAP_ROUND);
    cairo_set_line_join(context_.get(), CAIRO_LINE_JOIN_ROUND);
    cairo_stroke(context_.get());
  }

 protected:
  CairoSurface(double width_mm, double height_mm) : PrintSurface(width_mm, height_mm) {}

  void Attach(cairo_surface_t* surface, double device_units_per_mm) {
    surface_.reset(surface);
    context_.reset(cairo_create(surface));
    cairo_set_antialias(context_.get(), CAIRO_ANTIALIAS_BEST);
    cairo_scale(context_.get(), device_units_per_mm, device_units_per_mm);
  }

  void Check(cairo_status_t status) const {
    if (status == CAIRO_STATUS_SUCCESS) return;
    throw Error(ErrorCode::kFile, std::string("cannot draw: ") + cairo_status_to_string(status));
  }

  virtual void SetGrey(double grey) = 0;
  cairo_surface_t* surface() const { return surface_.get(); }
  cairo_t* context() const { return context_.get(); }

 private:
  std::unique_ptr<cairo_surface_t, CairoDelete> surface_;
  std::unique_ptr<cairo_t, CairoDelete> context_;
};

class PdfSurface : public CairoSurface {
 public:
  PdfSurface(double width_mm, double height_mm) : CairoSurface(width_mm, height_mm) {
    const auto append = [](void* surface, const unsigned char* data, unsigned length) {
      return static_cast<PdfSurface*>(surface)->Append(reinterpret_cast<const char*>(data), length);
    };
    Attach(cairo_pdf_surface_create_for_stream(append, this, width_mm * kPointsPerMm,
                                               height_mm * kPointsPerMm),
           kPointsPerMm);
    // Readable by every printer, and the same structure from every version of cairo.
    cairo_pdf_surface_restrict_to_version(surface(), CAIRO_PDF_VERSION_1_4);
    // No date: the same design gives the same bytes.
    cairo_pdf_surface_set_metadata(surface(), CAIRO_PDF_METADATA_CREATE_DATE, "");
  }

  // Where Finish was not reached, the surface still writes its end, to bytes_.
  ~PdfSurface() override { cairo_surface_finish(surface()); }

  void NextPage() override { cairo_show_page(context()); }
  Point2 Aligned(Point2 point, double) const override { return point; }

  std::string Finish() override {
    cairo_show_page(context());
    Check(cairo_status(context()));
    cairo_surface_finish(surface());
    Check(cairo_surface_status(surface()));
    // Which cairo does not always tell.
    if (is_full_) Check(CAIRO_STATUS_NO_MEMORY);
    return std::move(bytes_);
  }

 private:
  cairo_status_t Append(const char* data, unsigned length) {
    try {
      bytes_.append(data, length);
    } catch (const std::bad_alloc&) {
      is_full_ = true;
    }
    return is_full_ ? CAIRO_STATUS_NO_MEMORY : CAIRO_STATUS_SUCCESS;
  }
  void SetGrey(double grey) override { cairo_set_source_rgb(context(), grey, grey, grey); }

  std::string bytes_;
  bool is_full_ = false;
};

struct PngPage {
  int width, height;
  uint32_t pixels_per_metre;
  const uint8_t* ink;
  int stride;
};

void AppendPng(png_structp png, png_bytep data, png_size_t length) {
  bool full = false;
  try {
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<char*>(data), length);
  } catch (const std::bad_alloc&) {
    full = true;
  }
  if (full) png_error(png, "out of memory");
}

// Everything with a destructor belongs to the caller, since libpng leaves by longjmp.
bool EncodePng(const PngPage& page, std::vector<uint8_t>* row, std::string* bytes) {
  png_structp png = png_create_write_struct(
      PNG_LIBPNG_VER_STRING, nullptr, [](png_structp p, png_const_charp) { png_longjmp(p, 1); },
      [](png_structp, png_const_charp) {});
  if (png == nullptr) return false;
  png_infop info = png_create_info_struct(png);
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, bytes, AppendPng, nullptr);
  png_set_IHDR(png, info, page.width, page.height, 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_pHYs(png, info, page.pixels_per_metre, page.pixels_per_metre, PNG_RESOLUTION_METER);
  png_write_info(png, info);
  for (int y = 0; y < page.height; ++y) {
    const uint8_t* ink = page.ink + static_cast<ptrdiff_t>(y) * page.stride;
    for (int x = 0; x < page.width; ++x) (*row)[x] = static_cast<uint8_t>(255 - ink[x]);
    png_write_row(png, row->data());
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

// One byte a pixel: cairo's alpha-only format holds the ink, so that the largest picture takes
// a quarter of what RGB would.
class PngSurface : public CairoSurface {
 public:
  PngSurface(int width, int height, double dpi)
      : CairoSurface(width * 25.4 / dpi, height * 25.4 / dpi), dpi_(dpi) {
    Attach(cairo_image_surface_create(CAIRO_FORMAT_A8, width, height), dpi / 25.4);
    Check(cairo_surface_status(surface()));
  }

  void NextPage() override { FailArgument("a PNG has one page"); }

  Point2 Aligned(Point2 point, double unit_mm) const override {
    const double scale = dpi_ / 25.4, unit = unit_mm * scale;
    if (std::abs(unit - std::round(unit)) > 1e-6) return point;
    return {std::round(point.x * scale) / scale, std::round(point.y * scale) / scale};
  }

  std::string Finish() override {
    Check(cairo_status(context()));
    cairo_surface_flush(surface());
    const PngPage page{
        cairo_image_surface_get_width(surface()), cairo_image_surface_get_height(surface()),
        static_cast<uint32_t>(std::lround(dpi_ / 0.0254)), cairo_image_surface_get_data(surface()),
        cairo_image_surface_get_stride(surface())};
    std::vector<uint8_t> row(page.width);
    std::string bytes;
    if (!EncodePng(page, &row, &bytes)) {
      throw Error(ErrorCode::kFile, "cannot encode PNG: out of memory");
    }
    return bytes;
  }

 private:
  // Ink of `grey` over what is there; white takes the ink away.
  void SetGrey(double grey) override {
    cairo_set_operator(context(), grey < 1 ? CAIRO_OPERATOR_OVER : CAIRO_OPERATOR_DEST_OUT);
    cairo_set_source_rgba(context(), 0, 0, 0, grey < 1 ? 1 - grey : 1);
  }

  double dpi_;
};

// Written as text here: cairo's SVG holds identifiers that differ from call to call, and
// coordinates of 1/256 mm.
class SvgSurface : public PrintSurface {
 public:
  SvgSurface(double width_mm, double height_mm) : PrintSurface(width_mm, height_mm) {
    const std::string w = Number(width_mm), h = Number(height_mm);
    text_ =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\"" +
        (" width=\"" + w + "mm\" height=\"" + h) + "mm\" viewBox=\"0 0 " + w + " " + h + "\">\n";
  }

  void Fill(const std::vector<Outline>& outlines, double grey) override {
    text_ += "<path fill=\"" + Color(grey) + "\" d=\"";
    for (const Outline& outline : outlines) {
      if (outline.radius > 0) text_ += Circle(outline.center, outline.radius);
      AppendLine(outline.points);
      text_ += "Z";
    }
    text_ += "\"/>\n";
  }

  void Stroke(const std::vector<std::vector<Point2>>& lines, double line_width,
              double grey) override {
    text_ += "<path fill=\"none\" stroke=\"" + Color(grey) + "\" stroke-width=\"" +
             Number(line_width) + "\" stroke-linecap=\"round\" stroke-linejoin=\"round\" d=\"";
    for (const auto& line : lines) AppendLine(line);
    text_ += "\"/>\n";
  }

  void NextPage() override { FailArgument("an SVG has one page"); }
  Point2 Aligned(Point2 point, double) const override { return point; }
  std::string Finish() override { return text_ + "</svg>\n"; }

 private:
  static std::string Number(double value) {
    char text[64];
    char* end = std::to_chars(text, text + sizeof(text), value, std::chars_format::fixed, 6).ptr;
    while (end[-1] == '0') --end;
    if (end[-1] == '.') --end;
    const std::string number(text, end);
    return number == "-0" ? "0" : number;
  }

  static std::string Pair(Point2 p) { return Number(p.x) + " " + Number(p.y); }

  static std::string Circle(Point2 center, double radius) {
    const std::string r = Number(radius);
    const std::string arc = "A" + r + " " + r + " 0 0 1 ";
    const std::string left = Pair({center.x - radius, center.y});
    const std::string right = Pair({center.x + radius, center.y});
    return "M" + left + arc + right + arc + left;
  }

  static std::string Color(double grey) {
    const std::string level = std::to_string(std::lround(255 * grey));
    return "rgb(" + level + "," + level + "," + level + ")";
  }

  void AppendLine(const std::vector<Point2>& points) {
    for (size_t i = 0; i < points.size(); ++i) text_ += (i == 0 ? "M" : "L") + Pair(points[i]);
  }

  std::string text_;
};

}  // namespace

PrintFormat PrintFormatOf(const std::string& path) {
  const std::string extension = LowerExtension(path);
  if (extension == ".png") return PrintFormat::kPng;
  if (extension == ".svg") return PrintFormat::kSvg;
  if (extension == ".pdf") return PrintFormat::kPdf;
  throw Error(ErrorCode::kFile, "cannot write '" + path + "': unknown extension '" + extension +
                                    "', expected .png, .svg or .pdf");
}

std::unique_ptr<PrintSurface> MakePrintSurface(PrintFormat format, double width_mm,
                                               double height_mm, double dpi) {
  if (format == PrintFormat::kSvg) return std::make_unique<SvgSurface>(width_mm, height_mm);
  if (format == PrintFormat::kPdf) return std::make_unique<PdfSurface>(width_mm, height_mm);
  const double width = std::max(1.0, std::round(width_mm * dpi / 25.4));
  const double height = std::max(1.0, std::round(height_mm * dpi / 25.4));
  if (width > kMaxImageSide || height > kMaxImageSide) {
    FailArgument("a PNG of " + std::to_string(std::llround(width)) + "x" +
                 std::to_string(std::llround(height)) + " pixels is larger than " +
                 std::to_string(kMaxImageSide) + " a side");
  }
  return std::make_unique<PngSurface>(static_cast<int>(width), static_cast<int>(height), dpi);
}

}  // namespace topotag
