#include "host/print_surface.h"

#include <gtest/gtest.h>

#include <string>

#include "topotag/error.h"

namespace topotag {
namespace {

std::string NextPageError(PrintFormat format) {
  try {
    MakePrintSurface(format, 20, 10, 100)->NextPage();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "no error";
}

TEST(PrintSurfaceTest, PicturesHaveOnePage) {
  EXPECT_EQ(NextPageError(PrintFormat::kPng), "a PNG has one page");
  EXPECT_EQ(NextPageError(PrintFormat::kSvg), "an SVG has one page");
  EXPECT_EQ(NextPageError(PrintFormat::kPdf), "no error");
}

}  // namespace
}  // namespace topotag
