// All stages from the image to the components, one behind the other, on random frames.

#include "tests/segmentation_parity.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <iostream>

#include "tests/frames.h"

namespace topotag {
namespace {

constexpr uint64_t kFramesPerTest = 1000;

class SegmentationParityTest : public ::testing::TestWithParam<int> {};

// Ten of them: every kind of content, shape and preset, every target and thread count.
TEST_P(SegmentationParityTest, AThousandFrames) {
  SegmentationParity parity({1, 2, 3, 4});
  const uint64_t first = kFramesPerTest * static_cast<uint64_t>(GetParam());
  Random random(first);
  for (uint64_t seed = first; seed < first + kFramesPerTest; ++seed) {
    const FrameCase c = RandomFrameCase(seed);
    const GuardedImage image = MakeFrame(c, random.Chance(50) ? Guard::kBegin : Guard::kEnd);
    ThresholdParams params;
    if (random.Chance(20)) params.preset = Preset::kPaper;
    params.contrast_sixteenths = random.Between(6, 8);
    ASSERT_EQ(parity.Difference(image.view(), params, &random), "") << c;
  }
  if (!parity.has_opencl()) std::cout << "without opencl\n";
}

INSTANTIATE_TEST_SUITE_P(Frames, SegmentationParityTest, ::testing::Range(0, 10));

// Frames of a camera's size: more than one strip for every thread.
TEST(LargeFrameParityTest, EveryKind) {
  SegmentationParity parity({1, 2, 3, 4, 7});
  Random random(1);
  for (int kind = 0; kind < kFrameKinds; ++kind) {
    const FrameCase c{random.Between(900, 1400), random.Between(600, 1000), 3, FrameKind(kind),
                      static_cast<uint64_t>(kind)};
    ASSERT_EQ(parity.Difference(MakeFrame(c).view(), {}, &random), "") << c;
  }
}

}  // namespace
}  // namespace topotag
