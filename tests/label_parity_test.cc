// simd::Label and simd::Measure against those of fallback/.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "fallback/label.h"
#include "host/workers.h"
#include "simd/label.h"
#include "simd/measure.h"
#include "tests/frames.h"
#include "tests/guarded.h"
#include "tests/parity.h"
#include "tests/simd_targets.h"

namespace topotag {
namespace {

// With one workspace for all pictures of a test.
class LabelParityTest : public SimdTest {
 protected:
  void ExpectEqual(const BitImage& bits, Workers* workers, const FrameCase& c) {
    scalar::Label(bits, &scalar_workspace_, &expected_);
    simd::Label(bits, workers, &workspace_, &actual_);
    ASSERT_EQ(Difference(expected_, actual_), "") << Describe(c, workers);
    Random random(c.seed);
    for (const int percent : {0, 3, 50, 100}) {
      ASSERT_NO_FATAL_FAILURE(ExpectEqualFeatures(percent, &random, workers))
          << Describe(c, workers);
    }
  }
  void ExpectEqual(const FrameCase& c, Workers* workers) {
    ExpectEqual(MakeFrameBits(c), workers, c);
  }
  void ExpectEqual(const FrameCase& c) { ExpectEqual(c, &one_); }

  Workers one_{1};

 private:
  std::string Describe(const FrameCase& c, Workers* workers) const {
    return testing::PrintToString(c) + ", " + target() + ", " + std::to_string(workers->threads()) +
           " threads";
  }

  void ExpectEqualFeatures(int percent, Random* random, Workers* workers) {
    size_t slots;
    const CanonicalComponents canonical(expected_);
    const std::vector<uint32_t> slot =
        RandomSlots(canonical.parent.size(), percent, random, &slots);
    GuardedArray<uint32_t> expected_slot(expected_.label_end()), actual_slot(actual_.label_end());
    SlotsOfLabels(expected_, slot, &expected_slot);
    SlotsOfLabels(actual_, slot, &actual_slot);
    std::vector<Feature> expected(slots);
    GuardedArray<Feature> actual(slots);
    scalar::Measure(expected_, expected_slot.data(), slots, expected.data());
    simd::Measure(actual_, actual_slot.data(), slots, workers, &measure_, actual.data());
    ASSERT_EQ(Difference(expected.data(), actual.data(), slots), "") << percent << " % measured";
  }

  scalar::LabelWorkspace scalar_workspace_;
  simd::LabelWorkspace workspace_;
  simd::MeasureWorkspace measure_;
  Components expected_, actual_;
};

TOPOTAG_INSTANTIATE_SIMD_TEST(LabelParityTest);

TEST_P(LabelParityTest, AllPicturesOfFourByThree) {
  for (int picture = 0; picture < 1 << 12 && !HasFatalFailure(); ++picture) {
    const BitImage bits =
        MakeBits(4, 3, [=](int x, int y) { return (picture >> (4 * y + x) & 1) != 0; });
    ExpectEqual(bits, &one_, {4, 3, 0, FrameKind::kNoise, static_cast<uint64_t>(picture)});
  }
}

TEST_P(LabelParityTest, SizesAroundTheWords) {
  uint64_t seed = 0;
  for (const int width : {1,   2,   3,   15,  31,  33,  62,  63,  64,  65,  127,  128,  129,
                          131, 191, 193, 255, 256, 257, 511, 512, 513, 515, 1023, 1025, 1027}) {
    for (const int height : {1, 2, 3, 15, 16, 17, 33}) {
      for (int kind = static_cast<int>(FrameKind::kCheckerboard); kind < kFrameKinds; ++kind) {
        if (HasFatalFailure()) return;
        ExpectEqual({width, height, 0, FrameKind(kind), ++seed});
      }
    }
  }
}

// Rows of any number of runs, with rows below that correspond one to one, nearly so, or not at all.
TEST_P(LabelParityTest, RowsThatCorrespond) {
  Random random(6);
  for (uint64_t seed = 0; seed < 1500 && !HasFatalFailure(); ++seed) {
    const int width = random.Between(1, 300), height = random.Between(2, 12);
    const int gap = random.Between(1, 12), jitter = random.Between(0, 3);
    std::vector<int> change;
    for (int x = random.Below(gap + 1); x < width; x += random.Between(1, 2 * gap)) {
      change.push_back(x);
    }
    std::vector<std::vector<bool>> rows;
    for (int y = 0; y < height; ++y) {
      std::vector<bool> flip(static_cast<size_t>(width));
      for (int& at : change) {
        if (random.Chance(20)) at += random.Between(-jitter, jitter);
        if (random.Chance(2)) at += random.Between(-gap, gap);
        if (at >= 0 && at < width) flip[static_cast<size_t>(at)] = !flip[static_cast<size_t>(at)];
      }
      rows.emplace_back();
      bool white = false;
      for (const bool f : flip) rows.back().push_back(white = white != f);
    }
    const BitImage bits = MakeBits(width, height, [&](int x, int y) {
      return rows[static_cast<size_t>(y)][static_cast<size_t>(x)];
    });
    ExpectEqual(bits, &one_, {width, height, 0, FrameKind::kStripes, seed});
  }
}

TEST_P(LabelParityTest, LongestSides) {
  uint64_t seed = 0;
  for (const FrameKind kind :
       {FrameKind::kBinaryNoise, FrameKind::kCoarseNoise, FrameKind::kStripes, FrameKind::kComb}) {
    for (const int side : {1, 3, 17}) {
      for (int less = 0; less < 3; ++less) {
        if (HasFatalFailure()) return;
        ExpectEqual({kMaxImageSide - less, side, 0, kind, ++seed});
        ExpectEqual({side, kMaxImageSide - less, 0, kind, ++seed});
      }
    }
  }
  const FrameCase white{kMaxImageSide, 2, 0, FrameKind::kConstant, 0};
  ExpectEqual(MakeBits(kMaxImageSide, 2, [](int, int) { return true; }), &one_, white);
}

// Around the noise limit: of random bits a quarter white, 3/8 change.
TEST_P(LabelParityTest, NoiseAroundTheLimit) {
  Random random(8);
  for (uint64_t seed = 0; seed < 400 && !HasFatalFailure(); ++seed) {
    const int width = random.Between(1, 300), height = random.Between(1, 90);
    const int density = random.Between(18, 32) + 50 * random.Below(2);
    const BitImage bits = MakeBits(width, height, [&](int, int) { return random.Chance(density); });
    ExpectEqual(bits, &one_, {width, height, 0, FrameKind::kBinaryNoise, seed});
  }
}

TEST_P(LabelParityTest, EveryThreadCount) {
  for (int threads = 1; threads <= 8; ++threads) {
    Workers workers(threads);
    for (uint64_t seed = 0; seed < 130 && !HasFatalFailure(); ++seed) {
      ExpectEqual(RandomFrameCase(seed), &workers);
    }
    // Large enough for a strip each, with components across all of them.
    for (uint64_t seed = 0; seed < 26 && !HasFatalFailure(); ++seed) {
      Random random(seed);
      ExpectEqual({random.Between(500, 900), random.Between(300, 600), 0,
                   FrameKind(seed % kFrameKinds), seed},
                  &workers);
    }
  }
}

// Bars that begin the lower the farther left they stand, joined by one row in the middle: their
// labels are united one by one, from the largest to the smallest, after others have come to know
// the first of them by its own. With many specks, which take labels too.
TEST_P(LabelParityTest, ChainsOfLabelsAcrossStrips) {
  const int width = 1500, bars = 60, middle = 400;
  const auto white = [&](int x, int y) {
    if (x >= 12 * bars) return x / 4 % 2 == 0 && y / 4 % 2 == 0;
    const bool is_bar = x / 6 % 2 == 0 && y >= middle / 2 - 3 * (x / 12);
    if (y < middle) return is_bar;
    // Below the first bar a run of its own, and behind a gap the joint of all.
    return y < middle + 3 && (x < 2 || x > 3);
  };
  for (const int threads : {2, 3, 4}) {
    Workers workers(threads);
    for (int below = 380; below < 440 && !HasFatalFailure(); below += 2) {
      const FrameCase c{width, middle + below, 0, FrameKind::kComb, static_cast<uint64_t>(below)};
      ExpectEqual(MakeBits(c.width, c.height, white), &workers, c);
    }
  }
}

}  // namespace
}  // namespace topotag
