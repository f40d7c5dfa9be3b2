// Photographs of other people, read from a folder beside the checkout where there is one: all
// stages on every backend, target and thread count.

#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "tests/segmentation_parity.h"
#include "topotag/image_file.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;

class PhotoParityTest : public ::testing::TestWithParam<const char*> {};

// Whole, and a part that begins and ends anywhere.
TEST_P(PhotoParityTest, EveryStage) {
  const fs::path folder =
      fs::path(TOPOTAG_SOURCE_DIR).parent_path() / "shared" / "data" / GetParam();
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no photographs in " << folder;
  SegmentationParity parity({1, 2, 3, 4});
  Random random(3);
  const std::vector<std::string> files = ListImages(folder.string());
  for (const std::string& file : files) {
    const Image photo = ReadImage(file);
    ASSERT_EQ(parity.Difference(photo.view(), {}, &random), "") << file;
    const int x = random.Below(photo.width()), y = random.Below(photo.height());
    const ImageView part{photo.row(y) + x, random.Between(1, photo.width() - x),
                         random.Between(1, photo.height() - y), photo.stride()};
    ThresholdParams params;
    if (random.Chance(50)) params.preset = Preset::kPaper;
    ASSERT_EQ(parity.Difference(part, params, &random), "")
        << file << ": " << part.width << "x" << part.height << " at " << x << ", " << y;
  }
  EXPECT_GT(files.size(), 10u);
  std::cout << files.size() << " photographs" << (parity.has_opencl() ? "" : ", without opencl")
            << "\n";
}

INSTANTIATE_TEST_SUITE_P(Folders, PhotoParityTest,
                         testing::Values("topotag_real", "natural", "hard_negative", "peer_tags"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace topotag
