// Parity of the far markers' kernels: each Highway target against loops over pixels, at every
// width and place, and nothing written outside.

#include "host/far_spots.h"

#include <algorithm>
#include <vector>

#include "tests/frames.h"
#include "tests/simd_targets.h"

namespace topotag {
namespace {

constexpr uint8_t kCanary = 0xa5;

class FarSpotsTest : public SimdTest {};

bool IsSpot(const ImageView& image, int x, int y, int step, int depth) {
  if (y < kSpotBorder || y >= image.height - kSpotBorder || x < kSpotBorder ||
      x >= (image.width - kSpotBorder) / 8 * 8) {
    return false;
  }
  const auto brighter = [&](int dx, int dy) {
    return std::max(image.row(y + dy * step)[x + dx * step],
                    image.row(y + 2 * dy * step)[x + 2 * dx * step]);
  };
  const int least = std::min(std::min(brighter(-1, 0), brighter(1, 0)),
                             std::min(brighter(0, -1), brighter(0, 1)));
  return least - image.row(y)[x] >= depth;
}

TEST_P(FarSpotsTest, SpotsAreThoseOfAPixelLoop) {
  int spots = 0;
  for (const int width : {16, 17, 24, 31, 33, 40, 63, 64, 65, 79, 80, 95, 127, 129, 161, 203}) {
    const GuardedImage frame = MakeFrame({width, 37, 3, FrameKind::kNoise, uint64_t(width)});
    const ImageView image = frame.view();
    for (int step = 1; step <= 2; ++step) {
      for (int y = 0; y < image.height; ++y) {
        for (int x0 = 0; x0 < width; x0 += y % 3 == 0 ? 8 : 40) {
          const int x1 = std::min(width, x0 + 8 * (1 + y % 5 * 3));
          std::vector<uint8_t> bits(static_cast<size_t>((width + 7) / 8 + 2), kCanary);
          const int depth = 10 + y;
          FindSpots(image, y, x0, x1, step, depth, bits.data());
          const auto count = static_cast<int>(bits.size());
          for (int byte = 0; byte < count; ++byte) {
            int expected = kCanary;
            if (8 * byte >= x0 && 8 * byte < x1) {
              expected = 0;
              for (int k = 0; k < 8; ++k) {
                expected |= static_cast<int>(IsSpot(image, 8 * byte + k, y, step, depth)) << k;
              }
              spots += __builtin_popcount(static_cast<unsigned>(expected));
            }
            ASSERT_EQ(bits[static_cast<size_t>(byte)], expected)
                << "row " << y << " columns from " << 8 * byte << ", width " << width << " part "
                << x0 << " to " << x1 << " step " << step;
          }
        }
      }
    }
  }
  EXPECT_GT(spots, 1000);
}

TEST_P(FarSpotsTest, HalvedRowsAreThoseOfAPixelLoop) {
  for (int width = 2; width < 300; width += width < 80 ? 1 : 7) {
    const GuardedImage frame = MakeFrame({width, 4, 5, FrameKind::kNoise, uint64_t(width)});
    const ImageView image = frame.view();
    for (int x0 = 0; x0 < width / 2; x0 += 3) {
      const int count = width / 2 - x0;
      std::vector<uint8_t> out(static_cast<size_t>(count + 1), kCanary);
      HalveRow(image, 1, x0, count, out.data());
      for (int x = 0; x < count; ++x) {
        const uint8_t* upper = image.row(2) + 2 * (x0 + x);
        const uint8_t* lower = image.row(3) + 2 * (x0 + x);
        ASSERT_EQ(out[static_cast<size_t>(x)], (upper[0] + upper[1] + lower[0] + lower[1] + 2) / 4)
            << "column " << x << ", width " << width << " from " << x0;
      }
      ASSERT_EQ(out.back(), kCanary);
    }
  }
}

TOPOTAG_INSTANTIATE_SIMD_TEST(FarSpotsTest);

}  // namespace
}  // namespace topotag
