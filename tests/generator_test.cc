#include "topotag/generator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tests/temporary_folder.h"
#include "topotag/error.h"
#include "topotag/image.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;

constexpr InnerShape kInnerShapes[] = {InnerShape::kSquare, InnerShape::kCircle,
                                       InnerShape::kHexagon};
constexpr double kUnitPx = 10;

MarkerDesign Design(int n, uint64_t id) {
  MarkerDesign design;
  design.family = Family(n);
  design.id = id;
  return design;
}

// A unit of exactly ten pixels.
PrintOptions TenPixels(Family family) {
  PrintOptions print;
  print.size_mm = 2.54 * family.white_side();
  print.dpi = 100;
  return print;
}

std::string Bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

size_t Count(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

uint32_t BigEndian(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes.at(i));
  return value;
}

class GeneratorTest : public testing::Test {
 protected:
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  size_t FileCount() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }

  cv::Mat Picture(const MarkerDesign& design, const PrintOptions& print) const {
    WriteMarker(design, print, Path("picture.png"));
    return cv::imread(Path("picture.png"), cv::IMREAD_UNCHANGED);
  }

  std::string MarkerError(const MarkerDesign& design, const PrintOptions& print,
                          const std::string& path, ErrorCode code) const {
    try {
      WriteMarker(design, print, path);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code);
      return error.what();
    }
    return "no error";
  }

  std::string SheetError(const std::vector<MarkerDesign>& designs, const PrintOptions& print,
                         const SheetOptions& sheet, const std::string& name) const {
    try {
      WriteSheet(designs, print, sheet, Path(name));
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      return error.what();
    }
    return "no error";
  }

  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

// The grey level at a point in units, for a picture that spans design's frame and margin.
class Probe {
 public:
  Probe(const cv::Mat& picture, const MarkerDesign& design)
      : picture_(picture),
        origin_(design.family.white_side() / 2.0 + design.frame + design.margin) {}

  int operator()(double x, double y) const {
    return picture_.at<uint8_t>(static_cast<int>(std::floor((y + origin_) * kUnitPx)),
                                static_cast<int>(std::floor((x + origin_) * kUnitPx)));
  }

 private:
  const cv::Mat& picture_;
  double origin_;
};

TEST_F(GeneratorTest, PngShowsTheBits) {
  for (const InnerShape inner : kInnerShapes) {
    for (int n = Family::kMinN; n <= Family::kMaxN; ++n) {
      MarkerDesign design = Design(n, 0x5a5a93c71e0f2468u % Family(n).size());
      design.inner = inner;
      design.margin = 2;
      const cv::Mat picture = Picture(design, TenPixels(design.family));
      ASSERT_EQ(picture.type(), CV_8UC1);
      ASSERT_EQ(picture.cols, (design.family.white_side() + 6) * kUnitPx);
      ASSERT_EQ(picture.rows, picture.cols);
      const Probe grey(picture, design);
      const auto vertices = ModelVertices(design.family);
      for (int v = 0; v < design.family.vertex_count(); ++v) {
        const double x = vertices[v].x, y = vertices[v].y;
        const bool hole = v < 2 || IdBit(design.family, design.id, v);
        EXPECT_EQ(grey(x, y), hole ? 255 : 0) << n << " vertex " << v;
        EXPECT_EQ(grey(x, y - 0.4), hole ? 255 : 0) << n << " vertex " << v;
        for (const double around : {-1.0, 1.0}) {
          EXPECT_EQ(grey(x + around, y), 0) << n << " vertex " << v;
          EXPECT_EQ(grey(x, y + around), 0) << n << " vertex " << v;
          EXPECT_EQ(grey(x, y + 2 * around), 255) << n << " vertex " << v;
        }
      }
      EXPECT_EQ(grey(vertices[1].x + 2, vertices[1].y), 255);
      const double frame = design.family.white_side() / 2.0 + 0.5;
      EXPECT_EQ(grey(frame, 0), 0);
      EXPECT_EQ(grey(-frame, frame), 0);
      EXPECT_EQ(grey(frame - 1, frame - 1), 255);
      EXPECT_EQ(grey(frame + 1.4, -frame - 1.4), 255);
    }
  }
}

TEST_F(GeneratorTest, WholePixelUnitsAreCrisp) {
  for (const double margin : {0.0, 2.0, 2.37}) {
    for (const OuterShape outer : {OuterShape::kSquare, OuterShape::kCircle}) {
      MarkerDesign design = Design(4, 278);
      design.margin = margin;
      design.outer = outer;
      const cv::Mat picture = Picture(design, TenPixels(design.family));
      // Inside the white area (the circle's edge is soft wherever it lies).
      const int half = static_cast<int>(8.4 * kUnitPx);
      int black = 0;
      for (int y = picture.rows / 2 - half; y < picture.rows / 2 + half; ++y) {
        for (int x = picture.cols / 2 - half; x < picture.cols / 2 + half; ++x) {
          const int grey = picture.at<uint8_t>(y, x);
          ASSERT_TRUE(grey == 0 || grey == 255) << x << " " << y << " " << grey;
          black += grey == 0;
        }
      }
      // 14 nodes of 9, the baseline node of 15, 2 + 4 holes.
      EXPECT_EQ(black, (14 * 9 + 15 - 6) * kUnitPx * kUnitPx);
    }
  }
}

TEST_F(GeneratorTest, AntialiasingKeepsTheArea) {
  MarkerDesign design = Design(3, 127);
  design.inner = InnerShape::kCircle;
  design.frame = 0;
  PrintOptions print;
  print.size_mm = 37.3;
  print.dpi = 217;
  const cv::Mat picture = Picture(design, print);
  double ink = 0;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) ink += (255 - picture.at<uint8_t>(y, x)) / 255.0;
  }
  const double unit = print.size_mm / 13 * print.dpi / 25.4;
  const double lens = 4.5 * std::acos(2 / 3.0) - std::sqrt(5.0);
  const double black = M_PI * (9 * 2.25 - 9 * 0.25) - lens;
  EXPECT_NEAR(ink / (unit * unit), black, 0.005 * black);
}

TEST_F(GeneratorTest, PngCarriesItsResolution) {
  PrintOptions print;
  for (const double dpi : {72.0, 300.0, 1200.0}) {
    print.dpi = dpi;
    const cv::Mat picture = Picture(Design(4, 278), print);
    EXPECT_EQ(picture.cols, std::lround(50.0 / 17 * 19 * dpi / 25.4));
    const std::string bytes = Bytes(Path("picture.png"));
    const size_t chunk = bytes.find("pHYs");
    ASSERT_NE(chunk, std::string::npos);
    EXPECT_EQ(BigEndian(bytes, chunk + 4), std::lround(dpi / 0.0254));
    EXPECT_EQ(BigEndian(bytes, chunk + 8), std::lround(dpi / 0.0254));
    EXPECT_EQ(bytes.at(chunk + 12), 1);
  }
}

TEST_F(GeneratorTest, SvgIsExactInMillimetres) {
  MarkerDesign design = Design(4, 278);
  design.margin = 2;
  design.frame = 1.5;
  PrintOptions print;
  print.size_mm = 50;
  WriteMarker(design, print, Path("marker.svg"));
  const std::string svg = Bytes(Path("marker.svg"));
  const size_t at = svg.find(" width=");
  ASSERT_NE(at, std::string::npos);
  double width = 0, height = 0, box_width = 0, box_height = 0;
  ASSERT_EQ(
      std::sscanf(svg.c_str() + at, " width=\"%lfmm\" height=\"%lfmm\" viewBox=\"0 0 %lf %lf\"",
                  &width, &height, &box_width, &box_height),
      4);
  const double expected = 50.0 / 17 * (17 + 2 * 3.5);
  for (const double side : {width, height, box_width, box_height}) {
    EXPECT_NEAR(side, expected, 1e-6);
  }
  // Paper, frame, white area, 15 nodes, 6 holes; the last hole stands at (2, 6) units.
  EXPECT_EQ(Count(svg, "<path"), 3u + 15 + 6);
  double x = 0, y = 0;
  ASSERT_EQ(std::sscanf(svg.c_str() + svg.rfind("d=\"M"), "d=\"M%lf %lf", &x, &y), 2);
  EXPECT_NEAR(x, 50.0 / 17 * (12 + 2 - 0.5), 1e-6);
  EXPECT_NEAR(y, 50.0 / 17 * (12 + 6 - 0.5), 1e-6);
}

TEST_F(GeneratorTest, PdfIsExactInMillimetres) {
  MarkerDesign design = Design(5, 1234567);
  design.outer = OuterShape::kCircle;
  PrintOptions print;
  print.size_mm = 42;
  WriteMarker(design, print, Path("marker.pdf"));
  const std::string pdf = Bytes(Path("marker.pdf"));
  double width = 0, height = 0;
  ASSERT_EQ(
      std::sscanf(pdf.c_str() + pdf.find("/MediaBox"), "/MediaBox [ 0 0 %lf %lf", &width, &height),
      2);
  const double expected = 42 * (std::sqrt(2.0) + 2.0 / 21) / 25.4 * 72;
  EXPECT_NEAR(width, expected, 1e-4);
  EXPECT_NEAR(height, expected, 1e-4);
}

// Pixels that another program paints differently, edges aside: programs differ in how they
// soften an edge, but not two pixels away from it.
int Differences(const std::string& command, const std::string& result, const cv::Mat& expected) {
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  const cv::Mat other = cv::imread(result, cv::IMREAD_GRAYSCALE);
  EXPECT_EQ(other.size(), expected.size());
  if (other.size() != expected.size()) return -1;
  const auto flat = [&](int x, int y) {
    for (int i = 0; i < 25; ++i) {
      if (expected.at<uint8_t>(y + i / 5 - 2, x + i % 5 - 2) != expected.at<uint8_t>(y, x)) {
        return false;
      }
    }
    return true;
  };
  int differences = 0;
  for (int y = 2; y + 2 < other.rows; ++y) {
    for (int x = 2; x + 2 < other.cols; ++x) {
      if (flat(x, y)) differences += other.at<uint8_t>(y, x) != expected.at<uint8_t>(y, x);
    }
  }
  return differences;
}

TEST_F(GeneratorTest, PdfAndSvgLookLikeThePng) {
  const bool pdf = std::system("pdftoppm -v >/dev/null 2>&1") == 0;
  const bool svg = std::system("rsvg-convert --version >/dev/null 2>&1") == 0;
  if (!pdf && !svg) GTEST_SKIP() << "neither pdftoppm nor rsvg-convert is installed";
  for (const InnerShape inner : kInnerShapes) {
    for (const OuterShape outer :
         {OuterShape::kSquare, OuterShape::kCircle, OuterShape::kButterfly}) {
      MarkerDesign design = Design(4, 8390);
      design.inner = inner;
      design.outer = outer;
      design.margin = 1;
      PrintOptions print;
      print.dpi = 150;
      const cv::Mat picture = Picture(design, print);
      const std::string size = " " + std::to_string(picture.cols) + " ";
      WriteMarker(design, print, Path("marker.pdf"));
      WriteMarker(design, print, Path("marker.svg"));
      if (pdf) {
        EXPECT_EQ(Differences("pdftoppm -singlefile -gray -png -scale-to-x" + size +
                                  "-scale-to-y " + std::to_string(picture.rows) + " " +
                                  Path("marker.pdf") + " " + Path("pdf"),
                              Path("pdf.png"), picture),
                  0);
      }
      if (svg) {
        EXPECT_EQ(
            Differences("rsvg-convert -b white -w" + size + "-h " + std::to_string(picture.rows) +
                            " -o " + Path("svg.png") + " " + Path("marker.svg"),
                        Path("svg.png"), picture),
            0);
      }
    }
  }
}

TEST_F(GeneratorTest, TheSameDesignGivesTheSameBytes) {
  MarkerDesign design = Design(6, 987654321);
  design.outer = OuterShape::kButterfly;
  design.inner = InnerShape::kCircle;
  PrintOptions print;
  print.size_mm = 30;
  for (const std::string extension : {"png", "svg", "pdf"}) {
    WriteMarker(design, print, Path("a." + extension));
    WriteMarker(design, print, Path("b." + extension));
    EXPECT_EQ(Bytes(Path("a." + extension)), Bytes(Path("b." + extension)));
    WriteSheet({design, Design(3, 5)}, print, {}, Path("a." + extension));
    WriteSheet({design, Design(3, 5)}, print, {}, Path("b." + extension));
    EXPECT_EQ(Bytes(Path("a." + extension)), Bytes(Path("b." + extension)));
  }
  // A date would make the bytes differ from one second to the next.
  EXPECT_EQ(Bytes(Path("a.pdf")).find("CreationDate"), std::string::npos);
}

TEST_F(GeneratorTest, SheetsTakeAsManyPagesAsNeeded) {
  PrintOptions print;
  print.size_mm = 50;
  std::vector<MarkerDesign> designs;
  for (uint64_t id = 0; id < 25; ++id) designs.push_back(Design(4, id));
  // 19/17 * 50 mm = 55.9 mm: three columns on 190 mm, four rows of 63.9 mm on 277 mm.
  WriteSheet(designs, print, {}, Path("sheet.pdf"));
  const std::string pdf = Bytes(Path("sheet.pdf"));
  EXPECT_NE(pdf.find("/Count 3"), std::string::npos);
  EXPECT_EQ(Count(pdf, "/MediaBox"), 3u);
  EXPECT_NE(SheetError(designs, print, {}, "sheet.png").find("25 markers need 3 pages"),
            std::string::npos);
  EXPECT_NE(SheetError(designs, print, {}, "sheet.svg").find("25 markers need 3 pages"),
            std::string::npos);
  EXPECT_EQ(FileCount(), 1u);
}

// Without looking at all markers of a long list: here the last one would be refused.
TEST_F(GeneratorTest, TooManyForOnePageIsToldAtOnce) {
  PrintOptions print;
  print.size_mm = 50;
  std::vector<MarkerDesign> designs(25, Design(4, 0));
  designs.back().id = designs.back().family.size();
  EXPECT_NE(SheetError(designs, print, {}, "sheet.svg").find("25 markers need 3 pages"),
            std::string::npos);
}

TEST_F(GeneratorTest, SheetsShowMarkersAndLabels) {
  PrintOptions print;
  print.size_mm = 17 * 2.54;
  print.dpi = 100;
  SheetOptions sheet;
  sheet.page_width_mm = 2 * 19 * 2.54 + 2.54 * 4 + 2 * 25.4;
  sheet.page_height_mm = 19 * 2.54 + 2.54 * 4 + 2 * 25.4;
  sheet.page_margin_mm = 25.4;
  sheet.gap_mm = 2.54 * 4;
  WriteSheet({Design(4, 278), Design(4, 8390)}, print, sheet, Path("sheet.png"));
  const cv::Mat page = cv::imread(Path("sheet.png"), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(page.cols, 380 + 40 + 200);
  ASSERT_EQ(page.rows, 190 + 40 + 200);
  for (int i = 0; i < 2; ++i) {
    const Family family(4);
    const uint64_t id = i == 0 ? 278 : 8390;
    const int left = 100 + i * 230;
    for (int v = 2; v < family.vertex_count(); ++v) {
      const Point2 p = ModelVertices(family)[v];
      EXPECT_EQ(page.at<uint8_t>(100 + static_cast<int>((p.y + 9.5) * 10),
                                 left + static_cast<int>((p.x + 9.5) * 10)),
                IdBit(family, id, v) ? 255 : 0);
    }
    // The label's strokes stand in the gap below, away from marker and page margin.
    const cv::Mat gap = page(cv::Rect(left + 5, 290 + 10, 180, 20));
    int ink = 0;
    for (int y = 0; y < gap.rows; ++y) {
      for (int x = 0; x < gap.cols; ++x) ink += gap.at<uint8_t>(y, x) < 128;
    }
    EXPECT_GT(ink, 100);
    EXPECT_LT(ink, 900);
  }
  // Without a gap there is neither a label nor a cut mark.
  sheet.gap_mm = 0;
  WriteSheet({Design(4, 278)}, print, sheet, Path("bare.svg"));
  EXPECT_EQ(Bytes(Path("bare.svg")).find("stroke"), std::string::npos);
}

TEST_F(GeneratorTest, SheetErrors) {
  PrintOptions print;
  SheetOptions sheet;
  EXPECT_EQ(SheetError({}, print, sheet, "a.pdf"), "a sheet needs at least one marker");
  sheet.page_width_mm = 60;
  EXPECT_EQ(SheetError({Design(4, 0)}, print, sheet, "a.pdf"),
            "a marker of 55.8824 x 55.8824 mm with a gap of 8 mm below it does not fit a page of "
            "60 x 297 mm with margins of 10 mm");
  sheet.page_width_mm = std::nan("");
  EXPECT_EQ(SheetError({Design(4, 0)}, print, sheet, "a.pdf"),
            "page width nan mm is not within 1 .. 5000 mm");
  sheet = {};
  sheet.gap_mm = -1;
  EXPECT_EQ(SheetError({Design(4, 0)}, print, sheet, "a.pdf"),
            "gap -1 mm is not within 0 .. 5000 mm");
  sheet = {};
  EXPECT_EQ(SheetError({Design(4, 0), Design(4, 16384)}, print, sheet, "a.pdf"),
            "ID 16384 is out of range for family 4x4: 0 .. 16383");
  print.dpi = 5000;
  EXPECT_EQ(SheetError({Design(4, 0)}, print, sheet, "a.png"),
            "a PNG of 41339x58465 pixels is larger than 32766 a side");
  EXPECT_EQ(FileCount(), 0u);
}

TEST_F(GeneratorTest, BadSizesAreErrorsAndLeaveNothing) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto error = [&](double size, double dpi) {
    PrintOptions print;
    print.size_mm = size;
    print.dpi = dpi;
    return MarkerError(Design(4, 0), print, Path("a.png"), ErrorCode::kInvalidArgument);
  };
  EXPECT_EQ(error(0, 300), "size 0 mm is not within 1 .. 5000 mm");
  EXPECT_EQ(error(-50, 300), "size -50 mm is not within 1 .. 5000 mm");
  EXPECT_EQ(error(std::nan(""), 300), "size nan mm is not within 1 .. 5000 mm");
  EXPECT_EQ(error(infinity, 300), "size inf mm is not within 1 .. 5000 mm");
  EXPECT_EQ(error(50, 0), "resolution 0 dpi is not within 1 .. 100000 dpi");
  EXPECT_EQ(error(50, std::nan("")), "resolution nan dpi is not within 1 .. 100000 dpi");
  EXPECT_EQ(error(50, infinity), "resolution inf dpi is not within 1 .. 100000 dpi");
  EXPECT_EQ(error(25.4, 16.9),
            "a unit of 0.994118 px is too small to draw (size 25.4 mm at 16.9 dpi, family 4x4): "
            "at least 1 px is needed");
  EXPECT_EQ(error(500, 3000), "a PNG of 66003x66003 pixels is larger than 32766 a side");
  EXPECT_EQ(error(4900, 300), "picture width 5476.47 mm is not within 0 .. 5000 mm");
  EXPECT_EQ(MarkerError(Design(4, 16384), {}, Path("a.png"), ErrorCode::kInvalidArgument),
            "ID 16384 is out of range for family 4x4: 0 .. 16383");
  EXPECT_EQ(FileCount(), 0u);
  // dpi has no meaning where there are no pixels.
  EXPECT_NO_THROW(WriteMarker(Design(4, 0), {50, 0}, Path("a.svg")));
  EXPECT_EQ(error(25.4, 17), "no error");
}

TEST_F(GeneratorTest, BadPathsAreNamedAndLeaveNothing) {
  const auto error = [&](const std::string& path) {
    return MarkerError(Design(4, 0), {}, path, ErrorCode::kFile);
  };
  EXPECT_EQ(error(Path("a.bmp")), "cannot write '" + Path("a.bmp") +
                                      "': unknown extension '.bmp', expected .png, .svg or .pdf");
  EXPECT_EQ(error(Path("png")), "cannot write '" + Path("png") +
                                    "': unknown extension '', expected .png, .svg or .pdf");
  EXPECT_EQ(error(Path("no/a.png")),
            "cannot write '" + Path("no/a.png") + "': No such file or directory");
  EXPECT_EQ(FileCount(), 0u);
  fs::create_directory(Path("folder.pdf"));
  EXPECT_EQ(error(Path("folder.pdf")), "cannot write '" + Path("folder.pdf") + "': Is a directory");
  const std::string long_name = Path(std::string(300, 'a') + ".svg");
  EXPECT_EQ(error(long_name), "cannot write '" + long_name + "': File name too long");
  EXPECT_EQ(FileCount(), 1u);
}

TEST_F(GeneratorTest, AFailureKeepsTheOldFileAndASuccessReplacesIt) {
  std::ofstream(Path("a.PNG")) << "old";
  EXPECT_THROW(WriteMarker(Design(3, 128), {}, Path("a.PNG")), Error);
  EXPECT_EQ(Bytes(Path("a.PNG")), "old");
  WriteMarker(Design(3, 127), {}, Path("a.PNG"));
  EXPECT_EQ(Bytes(Path("a.PNG")).substr(1, 3), "PNG");
  EXPECT_EQ(FileCount(), 1u);
}

}  // namespace
}  // namespace topotag
