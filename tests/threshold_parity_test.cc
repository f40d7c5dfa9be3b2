// simd::ThresholdMap against scalar::ThresholdMap.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "fallback/threshold.h"
#include "host/workers.h"
#include "simd/threshold.h"
#include "tests/frames.h"
#include "tests/guarded.h"
#include "tests/parity.h"
#include "tests/simd_targets.h"

namespace topotag {
namespace {

// With one workspace for all frames of a test.
class ThresholdParityTest : public SimdTest {
 protected:
  void ExpectEqual(const FrameCase& c, const ImageView& image, const ThresholdParams& params,
                   Workers* workers) {
    scalar::ThresholdMap(image, params, &scalar_workspace_, &expected_);
    const VectorGuard<uint16_t> guard(&actual_.value, expected_.value.size());
    const VectorGuard<uint8_t> floor_guard(&actual_.floor, expected_.floor.size());
    const VectorGuard<uint8_t> ceiling_guard(&actual_.ceiling, expected_.ceiling.size());
    simd::ThresholdMap(image, params, workers, &workspace_, &actual_);
    ASSERT_EQ(Difference(expected_, actual_), "")
        << c << ", " << target() << ", " << workers->threads() << " threads, contrast "
        << params.min_contrast << ", sixteenths " << params.contrast_sixteenths;
    ASSERT_TRUE(guard.IsIntact() && floor_guard.IsIntact() && ceiling_guard.IsIntact()) << c;
  }
  void ExpectEqual(const FrameCase& c, const ThresholdParams& params = {}) {
    const Guard guard = c.seed % 2 == 0 ? Guard::kBegin : Guard::kEnd;
    ExpectEqual(c, MakeFrame(c, guard).view(), params, &one_);
  }

  Workers one_{1};
  scalar::ThresholdWorkspace scalar_workspace_;
  simd::ThresholdWorkspace workspace_;
  ThresholdGrid expected_, actual_;
};

TOPOTAG_INSTANTIATE_SIMD_TEST(ThresholdParityTest);

TEST_P(ThresholdParityTest, SizesAroundTheVectors) {
  uint64_t seed = 0;
  for (const int width : {1, 2, 15, 16, 17, 31, 32, 33, 35, 63, 64, 65, 67, 131}) {
    for (const int height : {1, 2, 3, 15, 16, 17, 18, 33, 65}) {
      for (int kind = 0; kind < kFrameKinds; ++kind, ++seed) {
        if (HasFatalFailure()) return;
        ExpectEqual({width, height, static_cast<int>(seed % 3), FrameKind(kind), seed});
      }
    }
  }
}

// The grid of corners has one column a tile and one more: sizes around whole vectors of them.
TEST_P(ThresholdParityTest, GridsAroundTheVectors) {
  uint64_t seed = 0;
  for (const int cols : {2, 7, 8, 9, 15, 16, 17, 19, 31, 32, 33, 35, 63, 64, 65, 67, 131}) {
    for (const int rows : {2, 3, 4, 5, 9}) {
      for (int round = 0; round < 6; ++round, ++seed) {
        if (HasFatalFailure()) return;
        ExpectEqual({16 * (cols - 1) - round % 3, 16 * (rows - 1) - round % 2, 0,
                     round < 3 ? FrameKind::kRectangles : FrameKind(seed % kFrameKinds), seed});
      }
    }
  }
}

TEST_P(ThresholdParityTest, LongestSides) {
  uint64_t seed = 0;
  for (const FrameKind kind : {FrameKind::kNoise, FrameKind::kRectangles, FrameKind::kConstant}) {
    for (const int side : {1, 17}) {
      ExpectEqual({kMaxImageSide, side, 1, kind, ++seed});
      ExpectEqual({side, kMaxImageSide, 0, kind, ++seed});
    }
  }
}

TEST_P(ThresholdParityTest, AnyParameters) {
  Random random(4);
  for (uint64_t seed = 0; seed < 600 && !HasFatalFailure(); ++seed) {
    ThresholdParams params;
    if (seed % 4 == 3) params.preset = Preset::kPaper;
    const int contrasts[] = {0, 1, 2, 20, 255, 256, random.Below(256)};
    params.min_contrast = contrasts[random.Below(7)];
    params.contrast_sixteenths = random.Between(0, 16);
    params.alpha = random.Below(256);
    params.beta = random.Below(256);
    params.bin_factor_percent = random.Between(50, 100);
    ExpectEqual(RandomFrameCase(seed), params);
  }
}

// Flat tiles of every level, with every small contrast, beside one that gives their corners a
// threshold: on both sides of it, and at it.
TEST_P(ThresholdParityTest, FlatTilesOfEveryLevel) {
  for (int contrast = 0; contrast <= 21; ++contrast) {
    if (HasFatalFailure()) return;
    GuardedImage image(16 * 70, 16 * 5, 0);
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const int tile = 70 * (y / 16) + x / 16;
        const int level = tile % 5 == 0 ? 40 + (x + y / 2) % 2 * 100 : tile % 256;
        const int noise = (x + 3 * (y / 2)) % 16 == 0 ? contrast : 0;
        image.row(y)[x] = static_cast<uint8_t>(std::min(level + noise, 255));
      }
    }
    const FrameCase c{image.width(), image.height(), 0, FrameKind::kConstant,
                      static_cast<uint64_t>(contrast)};
    ExpectEqual(c, image.view(), {}, &one_);
  }
}

TEST_P(ThresholdParityTest, EveryThreadCount) {
  for (int threads = 1; threads <= 8; ++threads) {
    Workers workers(threads);
    for (uint64_t seed = 0; seed < 60 && !HasFatalFailure(); ++seed) {
      FrameCase c = RandomFrameCase(seed);
      c.height += 400;
      ExpectEqual(c, MakeFrame(c).view(), {}, &workers);
    }
  }
}

TEST_P(ThresholdParityTest, BytesBetweenTheRowsDoNotMatter) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    FrameCase c = RandomFrameCase(seed);
    c.padding += 1;
    GuardedImage image = MakeFrame(c);
    ThresholdGrid before;
    simd::ThresholdMap(image.view(), {}, &one_, &workspace_, &before);
    image.FillPadding(seed + 77);
    simd::ThresholdMap(image.view(), {}, &one_, &workspace_, &actual_);
    ASSERT_EQ(Difference(before, actual_), "") << c;
  }
}

}  // namespace
}  // namespace topotag
