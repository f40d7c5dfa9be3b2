#include "fallback/binarize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "fallback/threshold.h"
#include "tests/random_image.h"

namespace topotag {
namespace {

// To the nearest whole number, halves up; not negative.
int64_t RoundDivide(int64_t a, int64_t b) { return (2 * a + b) / (2 * b); }

// The threshold of one pixel by its definition, grey levels. All numbers are small: nothing rounds
// but where the definition does.
int64_t SlowThreshold(const ThresholdGrid& grid, int x, int y) {
  const auto node = [&grid](int row, int col) {
    return int64_t{grid.value[static_cast<size_t>(row * grid.cols + col)]};
  };
  // The middle of four rows, in pixels below the tile's upper edge, and the pixel's centre, in half
  // pixels right of its left edge.
  const int row = y / 16, col = x / 16;
  const int64_t down = y % 16 / 4 * 4 + 2, right = 2 * (x % 16) + 1;
  const auto at_edge = [&](int c) {
    return RoundDivide(node(row, c) * (16 - down) + node(row + 1, c) * down, 16);
  };
  const int64_t between =
      RoundDivide(at_edge(col) * (32 - right) + at_edge(col + 1) * right, 32 * 8);
  const auto tile = static_cast<size_t>(row * (grid.cols - 1) + col);
  if (between < grid.floor[tile]) return grid.floor[tile];
  return between > grid.ceiling[tile] ? grid.ceiling[tile] : between;
}

ThresholdGrid RandomGrid(int width, int height, uint64_t seed) {
  ThresholdGrid grid;
  grid.Resize(width, height);
  Random random(seed);
  for (uint16_t& value : grid.value) {
    value = static_cast<uint16_t>(random.Below(kMaxThreshold + 1));
    if (random.Chance(10)) value = random.Chance(50) ? 0 : kMaxThreshold;
  }
  RandomizeBounds(&random, &grid);
  return grid;
}

// Colours and padding of all pixels; false at the first that is wrong.
bool ExpectBits(const ImageView& image, const ThresholdGrid& grid, const BitImage& bits,
                const ImageCase& c) {
  EXPECT_EQ(bits.width, image.width) << c;
  EXPECT_EQ(bits.height, image.height) << c;
  EXPECT_EQ(bits.words, (image.width + 63) / 64) << c;
  const size_t size = static_cast<size_t>(bits.words) * static_cast<size_t>(bits.height);
  EXPECT_EQ(bits.size(), size);
  EXPECT_EQ(bits.bits.size(), size + 2 * BitImage::kPadding);
  const auto is_zero = [](uint64_t word) { return word == 0; };
  EXPECT_TRUE(std::all_of(bits.bits.begin(), bits.bits.begin() + BitImage::kPadding, is_zero));
  EXPECT_TRUE(std::all_of(bits.bits.end() - BitImage::kPadding, bits.bits.end(), is_zero));
  if (::testing::Test::HasFailure()) return false;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < 64 * bits.words; ++x) {
      const bool white = IsWhite(bits, x, y);
      const bool expected = x < image.width && image.row(y)[x] >= SlowThreshold(grid, x, y);
      if (white == expected) continue;
      ADD_FAILURE() << "(" << y << ", " << x << ") is " << white << ": " << c;
      return false;
    }
  }
  return true;
}

TEST(BinarizeTest, EveryPixelIsItsDefinition) {
  BitImage bits;  // one for all sizes: what it held before must not matter
  scalar::ThresholdWorkspace workspace;
  ThresholdGrid grid;
  for (const ImageCase& c : AllCases()) {
    const PaddedImage image = MakeImage(c);
    const ThresholdGrid random = RandomGrid(c.width, c.height, c.seed);
    scalar::Binarize(image.view(), random, &bits);
    if (!ExpectBits(image.view(), random, bits, c)) return;
    scalar::ThresholdMap(image.view(), {}, &workspace, &grid);
    scalar::Binarize(image.view(), grid, &bits);
    if (!ExpectBits(image.view(), grid, bits, c)) return;
  }
}

// At its threshold a pixel is white, one level below it is black.
TEST(BinarizeTest, NotBelowTheThresholdIsWhite) {
  for (const ImageCase& c : AllCases()) {
    if (c.content != Content::kBlack) continue;
    const ThresholdGrid grid = RandomGrid(c.width, c.height, c.seed);
    PaddedImage image(c.width, c.height, c.padding);
    for (const int below : {0, 1}) {
      for (int y = 0; y < c.height; ++y) {
        for (int x = 0; x < c.width; ++x) {
          image.row(y)[x] =
              static_cast<uint8_t>(std::max<int64_t>(SlowThreshold(grid, x, y) - below, 0));
        }
      }
      BitImage bits;
      scalar::Binarize(image.view(), grid, &bits);
      for (int y = 0; y < c.height; ++y) {
        for (int x = 0; x < c.width; ++x) {
          const bool white = IsWhite(bits, x, y);
          const bool expected = below == 0 || SlowThreshold(grid, x, y) == 0;
          ASSERT_EQ(white, expected) << y << ", " << x << " of " << c;
        }
      }
    }
  }
}

TEST(BinarizeTest, BoundsAreOfTheirTileAlone) {
  const PaddedImage dark(48, 48, 0);
  PaddedImage bright(48, 48, 0);
  for (int y = 0; y < 48; ++y) std::fill_n(bright.row(y), 48, uint8_t{254});
  for (int white = 0; white < 9; ++white) {
    for (int black = 0; black < 9; ++black) {
      ThresholdGrid grid;
      grid.Resize(48, 48);
      std::fill(grid.value.begin(), grid.value.end(), uint16_t{8 * 100});
      std::fill(grid.floor.begin(), grid.floor.end(), uint8_t{0});
      std::fill(grid.ceiling.begin(), grid.ceiling.end(), uint8_t{255});
      grid.ceiling[static_cast<size_t>(white)] = 0;
      if (black != white) grid.floor[static_cast<size_t>(black)] = 255;
      BitImage of_dark, of_bright;
      scalar::Binarize(dark.view(), grid, &of_dark);
      scalar::Binarize(bright.view(), grid, &of_bright);
      for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < 48; ++x) {
          const int tile = 3 * (y / 16) + x / 16;
          ASSERT_EQ(IsWhite(of_dark, x, y), tile == white) << y << ", " << x;
          ASSERT_EQ(IsWhite(of_bright, x, y), tile == white || tile != black) << y << ", " << x;
        }
      }
    }
  }
}

TEST(BinarizeTest, ThresholdRowIsTheSameForTheRowsOfAGroup) {
  for (const ImageCase& c : AllCases()) {
    if (c.content != Content::kBlack) continue;
    const ThresholdGrid grid = RandomGrid(c.width, c.height, c.seed + 1);
    std::vector<uint8_t> row(static_cast<size_t>(c.width) + 1);
    for (int y = 0; y < c.height; ++y) {
      row.back() = 77;  // behind the width nothing is written
      scalar::ThresholdRow(grid, y, c.width, row.data());
      ASSERT_EQ(row.back(), 77) << c;
      for (int x = 0; x < c.width; ++x) {
        ASSERT_EQ(row[static_cast<size_t>(x)], SlowThreshold(grid, x, y))
            << y << ", " << x << ": " << c;
      }
    }
  }
}

// Interpolation of a plane gives the plane: fixes the positions of corners and pixel centres.
TEST(BinarizeTest, ThresholdsFollowAPlane) {
  const int width = 100, height = 90;
  const auto plane = [](double x, double y) { return 30 + 0.7 * (x + 0.5) + 0.9 * (y + 0.5); };
  ThresholdGrid grid;
  grid.Resize(width, height);
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      grid.row(r)[c] = static_cast<uint16_t>(std::lround(8 * plane(16 * c - 0.5, 16 * r - 0.5)));
    }
  }
  std::fill(grid.floor.begin(), grid.floor.end(), uint8_t{0});
  std::fill(grid.ceiling.begin(), grid.ceiling.end(), uint8_t{255});
  std::vector<uint8_t> row(static_cast<size_t>(width));
  for (int y = 0; y < height; ++y) {
    scalar::ThresholdRow(grid, y, width, row.data());
    const double middle = y / 4 * 4 + 1.5;
    for (int x = 0; x < width; ++x) {
      // Half a level, half an eighth, and the grid's own half eighth.
      EXPECT_NEAR(row[static_cast<size_t>(x)], plane(x, middle), 0.5 + 0.125) << y << ", " << x;
    }
  }
}

TEST(BinarizeTest, ReadsNothingBesideTheImage) {
  for (const ImageCase& c : AllCases()) {
    if (c.padding == 0 || c.content != Content::kNoise) continue;
    PaddedImage image = MakeImage(c);
    const ThresholdGrid grid = RandomGrid(c.width, c.height, c.seed);
    BitImage before, after;
    scalar::Binarize(image.view(), grid, &before);
    image.FillPadding(c.seed + 99);
    scalar::Binarize(image.view(), grid, &after);
    ASSERT_EQ(before.bits, after.bits) << c;
  }
}

}  // namespace
}  // namespace topotag
