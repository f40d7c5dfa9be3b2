// The noise limit of the labelling (host/pipeline.h): kMaxBlockChanges of a block of 64 x 16
// pixels.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "fallback/label.h"
#include "tests/flood_fill.h"
#include "tests/random_image.h"

namespace topotag {
namespace {

constexpr int kBlockCols = 64;

// The picture that the runs describe.
BitImage FromRuns(const Components& components) {
  BitImage bits;
  bits.Resize(components.width, components.height);
  for (int y = 0; y < bits.height; ++y) {
    const uint32_t begin = components.row_begin[static_cast<size_t>(y)];
    const uint32_t runs = components.row_runs[static_cast<size_t>(y)];
    for (uint32_t run = 1; run + 1 < runs; run += 2) {
      for (int x = components.bound[begin + run]; x < components.bound[begin + run + 1]; ++x) {
        bits.row(y)[x / 64] |= uint64_t{1} << (x % 64);
      }
    }
  }
  return bits;
}

BitImage Labelled(const BitImage& bits) {
  scalar::LabelWorkspace workspace;
  Components components;
  scalar::Label(bits, &workspace, &components);
  return FromRuns(components);
}

// A block of the picture, black but for what is drawn.
struct Block {
  BitImage* bits;
  int left;
  int top;

  void Set(int x, int y, bool white) const {
    uint64_t& word = bits->row(top + y)[(left + x) / 64];
    const uint64_t bit = uint64_t{1} << ((left + x) % 64);
    word = white ? word | bit : word & ~bit;
  }
  // `changes` in its first rows, an even number in each: every other pixel from column `first` on,
  // but not the last one, whose right neighbour counts in the next block.
  void Fill(int changes, int first = 1) const {
    for (int y = 0; y < kBlockRows; ++y) {
      for (int x = first; x < kBlockCols - 1 && changes > 0; x += 2, changes -= 2) Set(x, y, true);
    }
    ASSERT_EQ(changes, 0);
  }
  // Far above the limit, with its last column white in the first rows.
  void FillWithNoise(int white_rows = kBlockRows) const {
    Fill(62 * kBlockRows);
    for (int y = 0; y < white_rows; ++y) Set(kBlockCols - 1, y, true);
  }
  bool IsBlackIn(const BitImage& other) const {
    for (int y = top; y < std::min(top + kBlockRows, other.height); ++y) {
      for (int x = left; x < std::min(left + kBlockCols, other.width); ++x) {
        if (IsWhite(other, x, y)) return false;
      }
    }
    return true;
  }
};

BitImage Black(int width, int height) {
  return MakeBits(width, height, [](int, int) { return false; });
}

TEST(LabelNoiseTest, AtTheLimitABlockStaysOneMoreMakesItBlack) {
  for (const int left : {0, 64, 128}) {
    for (const int top : {0, 16, 32}) {
      BitImage bits = Black(192, 48);
      const Block block{&bits, left, top};
      block.Fill(kMaxBlockChanges);
      EXPECT_EQ(Labelled(bits).bits, bits.bits) << left << ", " << top;
      // The last pixel of its last row: one change here, the other one in the next block.
      block.Set(kBlockCols - 1, kBlockRows - 1, true);
      EXPECT_EQ(Labelled(bits).bits, Black(192, 48).bits) << left << ", " << top;
    }
  }
}

TEST(LabelNoiseTest, ChangesAroundABlockDoNotCountInIt) {
  BitImage bits = Black(192, 48);
  const Block block{&bits, 64, 16};
  block.Fill(kMaxBlockChanges);
  for (int x = 1; x < kBlockCols; x += 2) {
    block.Set(x, -1, true);
    block.Set(x, kBlockRows, true);
  }
  for (int y = 0; y < kBlockRows; ++y) {
    block.Set(-2, y, true);
    block.Set(kBlockCols + 1, y, true);
  }
  EXPECT_EQ(Labelled(bits).bits, bits.bits);
}

// White rows from a block's first pixel to its last one change once in it: also at the first
// column of the picture, against the black outside.
TEST(LabelNoiseTest, ChangesFromTheBlackToTheLeftCount) {
  for (const int left : {0, 64}) {
    for (const int white_rows : {8, 9}) {
      BitImage bits = Black(192, 16);
      const Block block{&bits, left, 0};
      block.Fill(kMaxBlockChanges - 8);
      for (int y = kBlockRows - white_rows; y < kBlockRows; ++y) {
        for (int x = 0; x < kBlockCols; ++x) block.Set(x, y, true);
      }
      EXPECT_EQ(block.IsBlackIn(Labelled(bits)), white_rows == 9) << left;
    }
  }
}

TEST(LabelNoiseTest, ChangesFromTheWhiteToTheLeftCount) {
  for (const int white_rows : {12, 13}) {
    BitImage bits = Black(128, 16);
    const Block block{&bits, 64, 0};
    block.Fill(kMaxBlockChanges - 12);
    for (int y = 0; y < white_rows; ++y) block.Set(-1, y, true);
    const BitImage labelled = Labelled(bits);
    EXPECT_EQ(block.IsBlackIn(labelled), white_rows == 13);
    EXPECT_TRUE(IsWhite(labelled, 63, 0));
  }
}

// Also where the block to the left is noise itself: its pixels count as they were.
TEST(LabelNoiseTest, ChangesFromNoiseToTheLeftCountToo) {
  for (const int white_rows : {12, 13}) {
    BitImage bits = Black(128, 16);
    const Block noise{&bits, 0, 0}, block{&bits, 64, 0};
    noise.FillWithNoise(white_rows);
    block.Fill(kMaxBlockChanges - 12);
    const BitImage labelled = Labelled(bits);
    EXPECT_TRUE(noise.IsBlackIn(labelled));
    EXPECT_EQ(block.IsBlackIn(labelled), white_rows == 13);
  }
}

// At the limit, and white where it meets the noise to its left: with that black, 16 more runs
// begin in it than were counted.
TEST(LabelNoiseTest, MoreRunsThanWereCounted) {
  BitImage bits = Black(256, 64);
  for (int top = 0; top < 64; top += kBlockRows) {
    for (const int left : {0, 128}) {
      const Block noise{&bits, left, top}, block{&bits, left + 64, top};
      noise.FillWithNoise();
      for (int y = 0; y < kBlockRows; ++y) {
        for (int x = 0; x < kBlockCols; ++x) block.Set(x, y, x % 4 < 2 || x >= 48);
      }
    }
  }
  const BitImage labelled = Labelled(bits);
  for (int y = 0; y < 64; ++y) {
    EXPECT_EQ(labelled.row(y)[0], 0U);
    EXPECT_EQ(labelled.row(y)[1], bits.row(y)[1]);
    EXPECT_EQ(labelled.row(y)[2], 0U);
    EXPECT_EQ(labelled.row(y)[3], bits.row(y)[3]);
  }
}

// Six rows of 64 changes each are at the limit: a band with fewer is never noise.
TEST(LabelNoiseTest, PartialBands) {
  for (int rows = 1; rows < kBlockRows; ++rows) {
    BitImage bits = Black(64, kBlockRows + rows);
    const Block block{&bits, 0, kBlockRows};
    for (int y = 0; y < std::min(rows, 6); ++y) {
      for (int x = 0; x < kBlockCols; x += 2) block.Set(x, y, true);
    }
    EXPECT_EQ(Labelled(bits).bits, bits.bits) << rows;
    if (rows <= 6) continue;
    block.Set(kBlockCols - 1, rows - 1, true);
    EXPECT_TRUE(block.IsBlackIn(Labelled(bits))) << rows;
  }
}

// The end of a white pixel in the last column counts where the word has room for it.
TEST(LabelNoiseTest, PartialWords) {
  for (int columns = 1; columns < kBlockCols; ++columns) {
    const int width = 64 + columns;
    BitImage bits = Black(width, 16);
    for (int y = 0; y < kBlockRows; ++y) {
      for (int x = 64 + (columns - 1) % 2; x < width; x += 2)
        bits.row(y)[1] |= uint64_t{1} << (x % 64);
    }
    const int changes = 16 * (columns + 1 - (columns - 1) % 2);
    const Block block{&bits, 64, 0};
    EXPECT_EQ(block.IsBlackIn(Labelled(bits)), changes > kMaxBlockChanges) << columns;
    EXPECT_EQ(Labelled(bits).bits, WithoutNoise(bits).bits) << columns;
  }
}

// Of random bits of density d, 2 d (1 - d) differ from their neighbour: at a quarter, 3/8, blocks
// are at the limit.
TEST(LabelNoiseTest, RandomPicturesAroundTheLimit) {
  Random random(3);
  int black = 0, kept = 0;
  for (int i = 0; i < 1500; ++i) {
    const int density = random.Between(15, 35) + 50 * random.Below(2);
    const int width = random.Between(1, 300), height = random.Between(1, 70);
    const BitImage bits = MakeBits(width, height, [&](int, int) { return random.Chance(density); });
    const BitImage labelled = Labelled(bits);
    ASSERT_EQ(labelled.bits, WithoutNoise(bits).bits) << width << "x" << height << ", " << i;
    for (int y = 0; y + kBlockRows <= height; y += kBlockRows) {
      for (int x = 0; x + kBlockCols <= width; x += kBlockCols) {
        const Block block{nullptr, x, y};
        ++(block.IsBlackIn(labelled) ? black : kept);
      }
    }
  }
  EXPECT_GT(black, 1000);
  EXPECT_GT(kept, 1000);
}

}  // namespace
}  // namespace topotag
