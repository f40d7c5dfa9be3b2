#include "host/upsample.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/simd_targets.h"

namespace topotag {
namespace {

// Catmull-Rom weights a quarter of a sample right of b, in 128ths.
int Cubic(int a, int b, int c, int d) { return -9 * a + 111 * b + 29 * c - 3 * d; }

int Floor(int value, int divisor) {
  return static_cast<int>(std::floor(static_cast<double>(value) / divisor));
}

// One pixel of the result by its definition: first along the row, to 8ths, then down the column.
int Definition(const ImageView& image, int x, int y) {
  const auto pixel = [&](int px, int py) {
    return int{image.row(std::clamp(py, 0, image.height - 1))[std::clamp(px, 0, image.width - 1)]};
  };
  const int dx = x % 2 == 0 ? -1 : 1;
  const int dy = y % 2 == 0 ? -1 : 1;
  const int px = x / 2;
  const auto eighths = [&](int py) {
    return Floor(
        Cubic(pixel(px - dx, py), pixel(px, py), pixel(px + dx, py), pixel(px + 2 * dx, py)) + 8,
        16);
  };
  const int sum =
      Cubic(eighths(y / 2 - dy), eighths(y / 2), eighths(y / 2 + dy), eighths(y / 2 + 2 * dy));
  return std::clamp(Floor(sum + 512, 1024), 0, 255);
}

using UpsampleTest = SimdTest;

TEST_P(UpsampleTest, IsItsDefinition) {
  std::mt19937 random(1);
  UpsampleWorkspace workspace;
  for (int round = 0; round < 300; ++round) {
    const int width = 1 + static_cast<int>(random() % (round % 3 == 0 ? 5 : 70));
    const int height = 1 + static_cast<int>(random() % (round % 4 == 0 ? 5 : 40));
    Image image(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        // Black and white alone overshoot most.
        image.row(y)[x] = static_cast<uint8_t>(round % 2 == 0 ? random() : (random() & 1) * 255);
      }
    }
    const ImageView result = Upsample(image.view(), &workspace);
    ASSERT_EQ(result.width, 2 * width);
    ASSERT_EQ(result.height, 2 * height);
    for (int y = 0; y < result.height; ++y) {
      for (int x = 0; x < result.width; ++x) {
        ASSERT_EQ(result.row(y)[x], Definition(image.view(), x, y))
            << target() << ", " << width << "x" << height << ", row " << y << ", column " << x;
      }
    }
  }
}

TOPOTAG_INSTANTIATE_SIMD_TEST(UpsampleTest);

}  // namespace
}  // namespace topotag
