// simd::Binarize against scalar::Binarize.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "fallback/binarize.h"
#include "host/workers.h"
#include "simd/binarize.h"
#include "tests/frames.h"
#include "tests/guarded.h"
#include "tests/parity.h"
#include "tests/simd_targets.h"

namespace topotag {
namespace {

ThresholdGrid RandomGrid(int width, int height, Random* random) {
  ThresholdGrid grid;
  grid.Resize(width, height);
  for (uint16_t& value : grid.value) {
    value = static_cast<uint16_t>(random->Below(kMaxThreshold + 1));
    if (random->Chance(20)) value = random->Chance(50) ? 0 : kMaxThreshold;
  }
  RandomizeBounds(random, &grid);
  return grid;
}

class BinarizeParityTest : public SimdTest {
 protected:
  void ExpectEqual(const ImageView& image, const ThresholdGrid& grid, Workers* workers,
                   uint64_t seed) {
    scalar::Binarize(image, grid, &expected_);
    const VectorGuard<uint64_t> guard(&actual_.bits, expected_.bits.size());
    simd::Binarize(image, grid, workers, &actual_);
    ASSERT_EQ(Difference(expected_, actual_), "")
        << image.width << "x" << image.height << ", stride " << image.stride << ", seed " << seed
        << ", " << target() << ", " << workers->threads() << " threads";
    ASSERT_TRUE(guard.IsIntact()) << image.width << "x" << image.height;
  }

  // Pixels at their thresholds, one level below and above, or anything.
  void ExpectEqual(int width, int height, int padding, uint64_t seed, Workers* workers) {
    Random random(seed);
    const ThresholdGrid grid = RandomGrid(width, height, &random);
    GuardedImage image(width, height, padding, seed % 2 == 0 ? Guard::kBegin : Guard::kEnd);
    image.FillPadding(seed);
    std::vector<uint8_t> threshold(static_cast<size_t>(width));
    for (int y = 0; y < height; ++y) {
      scalar::ThresholdRow(grid, y, width, threshold.data());
      for (int x = 0; x < width; ++x) {
        const int level = random.Chance(10)
                              ? random.Below(256)
                              : threshold[static_cast<size_t>(x)] + random.Between(-1, 1);
        image.row(y)[x] = static_cast<uint8_t>(std::clamp(level, 0, 255));
      }
    }
    ExpectEqual(image.view(), grid, workers, seed);
  }

  Workers one_{1};
  BitImage expected_, actual_;
};

TOPOTAG_INSTANTIATE_SIMD_TEST(BinarizeParityTest);

TEST_P(BinarizeParityTest, SizesAroundTheVectors) {
  uint64_t seed = 0;
  for (int width = 1; width <= 200; ++width) {
    for (const int height : {1, 3, 4, 5, 17, 33}) {
      if (HasFatalFailure()) return;
      ExpectEqual(width, height, static_cast<int>(seed % 4), seed, &one_);
      ++seed;
    }
  }
  for (const int width : {255, 256, 257, 259, 511, 512, 513, 515, 1023, 1024, 1025, 1027}) {
    ExpectEqual(width, 35, 3, ++seed, &one_);
  }
}

TEST_P(BinarizeParityTest, LongestSides) {
  uint64_t seed = 0;
  for (const int side : {1, 7}) {
    for (int less = 0; less < 3; ++less) {
      ExpectEqual(kMaxImageSide - less, side, less, ++seed, &one_);
      ExpectEqual(side, kMaxImageSide - less, less, ++seed, &one_);
    }
  }
}

// Thresholds between 0 and the largest in neighbouring corners: the steepest steps there are.
TEST_P(BinarizeParityTest, EveryLevelAgainstEveryStep) {
  for (const int from : {0, 1, 7, 8, 1000, 1019, 1020, kMaxThreshold - 1, kMaxThreshold}) {
    for (const int to : {0, 1, 7, 8, 1000, 1021, kMaxThreshold - 1, kMaxThreshold}) {
      GuardedImage image(48, 256, 0);
      ThresholdGrid grid;
      grid.Resize(48, 256);
      for (size_t i = 0; i < grid.value.size(); ++i) {
        grid.value[i] = static_cast<uint16_t>((i + i / 4) % 2 == 0 ? from : to);
      }
      std::fill(grid.floor.begin(), grid.floor.end(), uint8_t{0});
      std::fill(grid.ceiling.begin(), grid.ceiling.end(), uint8_t{255});
      for (int y = 0; y < 256; ++y) {
        for (int x = 0; x < 48; ++x) image.row(y)[x] = static_cast<uint8_t>(y + 37 * (x / 16));
      }
      ASSERT_NO_FATAL_FAILURE(ExpectEqual(image.view(), grid, &one_, 0)) << from << ", " << to;
    }
  }
}

TEST_P(BinarizeParityTest, EveryThreadCount) {
  for (int threads = 1; threads <= 8; ++threads) {
    Workers workers(threads);
    for (uint64_t seed = 0; seed < 40 && !HasFatalFailure(); ++seed) {
      Random random(seed);
      const int width = random.Between(1, 200), height = random.Between(1, 600);
      ExpectEqual(width, height, 5, seed, &workers);
    }
  }
}

// Every level in tiles of every kind, in all orders.
TEST_P(BinarizeParityTest, EveryLevelAgainstEveryBound) {
  for (const int threshold : {0, 8 * 100, kMaxThreshold}) {
    GuardedImage image(16 * 81, 256, 0);
    ThresholdGrid grid;
    grid.Resize(16 * 81, 256);
    std::fill(grid.value.begin(), grid.value.end(), static_cast<uint16_t>(threshold));
    for (size_t i = 0; i < grid.floor.size(); ++i) {
      // All sequences of three.
      const int kind = static_cast<int>(i / 3 / (i % 3 == 0 ? 1 : i % 3 == 1 ? 3 : 9) % 3);
      grid.floor[i] = kind == 1 ? 255 : 0;
      grid.ceiling[i] = kind == 2 ? 0 : 255;
    }
    for (int y = 0; y < 256; ++y) {
      for (int x = 0; x < 16 * 81; ++x) image.row(y)[x] = static_cast<uint8_t>(y + 17 * (x % 16));
    }
    ASSERT_NO_FATAL_FAILURE(ExpectEqual(image.view(), grid, &one_, 0)) << threshold;
  }
}

// What was in the bits before does not matter, at any size.
TEST_P(BinarizeParityTest, BitsKeepNothing) {
  for (uint64_t seed = 0; seed < 300; ++seed) {
    Random random(seed);
    const int width = random.Between(1, 150), height = random.Between(1, 40);
    const ThresholdGrid grid = RandomGrid(width, height, &random);
    const FrameCase c{width, height, 0, FrameKind::kNoise, seed};
    const GuardedImage image = MakeFrame(c);
    scalar::Binarize(image.view(), grid, &expected_);
    std::fill(actual_.bits.begin(), actual_.bits.end(), ~uint64_t{0});
    simd::Binarize(image.view(), grid, &one_, &actual_);
    ASSERT_EQ(Difference(expected_, actual_), "") << c;
  }
}

TEST_P(BinarizeParityTest, BytesBetweenTheRowsDoNotMatter) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    FrameCase c = RandomFrameCase(seed);
    c.padding += 1;
    Random random(seed);
    const ThresholdGrid grid = RandomGrid(c.width, c.height, &random);
    GuardedImage image = MakeFrame(c);
    simd::Binarize(image.view(), grid, &one_, &expected_);
    image.FillPadding(seed + 77);
    simd::Binarize(image.view(), grid, &one_, &actual_);
    ASSERT_EQ(Difference(expected_, actual_), "") << c;
  }
}

}  // namespace
}  // namespace topotag
