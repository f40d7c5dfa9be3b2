// The picture that `topotag detect --draw` writes.
#include "tools/draw.h"

#include <gtest/gtest.h>

#include "topotag/image.h"

namespace topotag::tools {
namespace {

TEST(DrawTest, UnknownBitsAreNotDrawnAsAnId) {
  const Image wall(200, 100);
  Detection known;
  known.id = 278;
  known.corners = {{{80, 60}, {120, 60}, {120, 90}, {80, 90}}};
  Detection unknown = known;
  unknown.unknown_bits = 1;
  const auto draw = [&](const Detection& detection) {
    return DrawDetections(wall.view(), {detection}, {});
  };
  const cv::Mat difference = draw(known) != draw(unknown);
  EXPECT_GT(cv::countNonZero(difference.reshape(1)), 0);
  EXPECT_EQ(cv::countNonZero(difference.rowRange(65, 100).reshape(1)), 0);
}

}  // namespace
}  // namespace topotag::tools
