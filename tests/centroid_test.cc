// The Highway kernels of host/centroid.h and host/levels.h against a plain scalar reference, on
// every target.
#include "host/centroid.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "host/levels.h"

namespace topotag {
namespace {

class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  int Between(int lo, int hi) {
    return lo + static_cast<int>(engine_() % static_cast<uint64_t>(hi - lo + 1));
  }

 private:
  std::mt19937_64 engine_;
};

// An image with random sides up to `largest`, whose rows end where their memory ends or, padded,
// where other bytes follow.
struct Pixels {
  Pixels(int largest, Random* random) {
    const int width = random->Between(1, largest), height = random->Between(1, largest);
    const int stride = width + random->Between(0, 3);
    bytes.resize(static_cast<size_t>(stride * (height - 1) + width));
    view = {bytes.data(), width, height, stride};
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random->Between(0, 255));
  }
  std::vector<uint8_t> bytes;
  ImageView view;
};

int16_t ValueAt(const LinearValue& value, int x, int y) {
  return static_cast<int16_t>(((value.base + y * value.dy) >> 8) + ((x * value.dx + 128) >> 8));
}

int Inside(int16_t distance, int reach, int one) {
  return std::min(std::max(reach - std::abs(int{distance}), 0), one);
}

int Scaled(int a, int b) { return (a * b + (1 << 14)) >> 15; }

DarknessSums ReferenceDarkness(const ImageView& image, const DarknessPatch& patch) {
  DarknessSums sums;
  for (int y = 0; y < patch.height; ++y) {
    for (int x = 0; x < patch.width; ++x) {
      if (y % patch.step != ReversedBits(x / kGroupColumns, patch.step)) continue;
      const int grey = image.row(patch.y + y)[patch.x + x];
      const int weight = Inside(ValueAt(patch.u, x, y), patch.reach_u, patch.one) *
                         Inside(ValueAt(patch.v, x, y), patch.reach_v, patch.one);
      const int relative = Scaled(grey << 7, ValueAt(patch.inverse_white, x, y));
      const int s = Scaled(weight, patch.black - relative);
      sums.sum += patch.step * s;
      sums.x += int64_t{patch.step} * s * x;
      sums.y += int64_t{patch.step} * s * y;
    }
  }
  return sums;
}

// A patch of any place and size in the image, whose weights end within it, as the contract asks.
DarknessPatch RandomPatch(const ImageView& image, Random* random) {
  DarknessPatch patch{};
  patch.width = random->Between(1, std::min(image.width, random->Between(0, 9) == 0 ? 500 : 40));
  patch.height = random->Between(1, std::min(image.height, random->Between(0, 9) == 0 ? 500 : 40));
  const int places = random->Between(0, 2);  // anywhere, or at one of the corners
  patch.x = places == 1 ? 0 : image.width - patch.width;
  patch.y = places == 1 ? 0 : image.height - patch.height;
  if (places == 0) {
    patch.x = random->Between(0, patch.x);
    patch.y = random->Between(0, patch.y);
  }
  const int size = std::max(patch.width, patch.height);
  patch.one = static_cast<int16_t>(size < 64 ? 128 : size < 200 ? 32 : 16);
  // One of the two distances runs along the row, so that the weight ends with the patch.
  const int slope = patch.one * 256;
  const int half = (patch.width - 1) * slope / 2;
  const int shear = random->Between(-slope / 4, slope / 4);
  patch.u = {-half, slope, 0};
  patch.v = {-patch.height / 2 * slope, shear, slope};
  patch.reach_u = static_cast<int16_t>(patch.width * patch.one / 2);
  patch.reach_v = static_cast<int16_t>(random->Between(0, patch.height * patch.one));
  patch.step = random->Between(0, 2) == 0 ? 1 << random->Between(1, 5) : 1;
  patch.black = static_cast<int16_t>(1 << random->Between(4, 13));
  // Within kMaxRelative also at the end of 500 pixels.
  patch.inverse_white = {random->Between(1300, 9500) << 8, random->Between(-300, 300),
                         random->Between(-300, 300)};
  return patch;
}

int32_t ReferenceLevel(const ImageView& image, int32_t x, int32_t y) {
  const auto within = [](int32_t place, int size) {
    return std::min(std::max(place, 0), (size - 1) << kPlaceShift);
  };
  x = within(x, image.width);
  y = within(y, image.height);
  const int x0 = x >> kPlaceShift;
  const int y0 = y >> kPlaceShift;
  const int x1 = std::min(x0 + 1, image.width - 1);
  const int y1 = std::min(y0 + 1, image.height - 1);
  const int fx = x >> (kPlaceShift - 8) & 255;
  const int fy = y >> (kPlaceShift - 8) & 255;
  const int upper = image.row(y0)[x0] * (256 - fx) + image.row(y0)[x1] * fx;
  const int lower = image.row(y1)[x0] * (256 - fx) + image.row(y1)[x1] * fx;
  return (upper * (256 - fy) + lower * fy) >> 8;
}

RingSums ReferenceRing(const ImageView& image, const Ring& ring) {
  RingSums sums{};
  const auto add = [&](int a, int b) {
    const int32_t level = ReferenceLevel(image, ring.x + a * ring.ux + b * ring.vx,
                                         ring.y + a * ring.uy + b * ring.vy);
    sums.sum += level;
    sums.a += a * level;
    sums.b += b * level;
  };
  for (const int side : {-4, 4}) {
    for (const int along : {-3, -1, 1, 3}) {
      add(side, along);
      add(along, side);
    }
  }
  return sums;
}

// The kernels' targets; needs the definitions that they are compiled with.
std::vector<int64_t> Targets() {
  std::vector<int64_t> targets;
  const int64_t all = (hwy::SupportedTargets() | HWY_EMU128) & HWY_TARGETS;
  for (int64_t rest = all; rest != 0; rest &= rest - 1) targets.push_back(rest & -rest);
  return targets;
}

class CentroidTest : public ::testing::TestWithParam<int64_t> {
 protected:
  void SetUp() override {
    hwy::SetSupportedTargetsForTest(GetParam());
    ASSERT_STREQ(CentroidTargetName(), hwy::TargetName(GetParam()));
  }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

TEST_P(CentroidTest, DarknessSumsEqualTheReference) {
  Random random(1);
  for (int i = 0; i < 3000; ++i) {
    const bool large = i % 100 == 0;
    const Pixels image(large ? 700 : 80, &random);
    const DarknessPatch patch = RandomPatch(image.view, &random);
    const DarknessSums expected = ReferenceDarkness(image.view, patch);
    DarknessSums sums;
    SumDarkness(image.view, &patch, 1, &sums);
    ASSERT_EQ(sums.sum, expected.sum) << "case " << i << " width " << patch.width;
    ASSERT_EQ(sums.x, expected.x) << "case " << i << " width " << patch.width;
    ASSERT_EQ(sums.y, expected.y) << "case " << i << " width " << patch.width;
  }
}

TEST_P(CentroidTest, RingSumsEqualTheReference) {
  constexpr int kOne = 1 << kPlaceShift;
  Random random(2);
  for (int i = 0; i < 3000; ++i) {
    const Pixels image(90, &random);
    const auto step = [&] { return random.Between(-2 * kOne, 2 * kOne); };
    const auto place = [&] { return random.Between(-10 * kOne, 70 * kOne); };
    const bool inside = random.Between(0, 1) != 0;  // all rings of a call, or hardly any
    std::vector<Ring> rings(static_cast<size_t>(random.Between(1, 20)));
    for (Ring& ring : rings) {
      ring = {place(), place(), step(), step(), step(), step()};
      if (inside) ring = {30 * kOne, 30 * kOne, step(), step(), step(), step()};
    }
    std::vector<RingSums> sums(rings.size());
    SumRings(image.view, rings.data(), static_cast<int>(rings.size()), sums.data());
    for (size_t r = 0; r < rings.size(); ++r) {
      const RingSums expected = ReferenceRing(image.view, rings[r]);
      ASSERT_EQ(sums[r].sum, expected.sum) << "case " << i << " ring " << r;
      ASSERT_EQ(sums[r].a, expected.a) << "case " << i << " ring " << r;
      ASSERT_EQ(sums[r].b, expected.b) << "case " << i << " ring " << r;
    }
  }
}

TEST_P(CentroidTest, LevelsEqualTheReference) {
  constexpr int kOne = 1 << kPlaceShift;
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Pixels image(60, &random);
    int32_t x[3 * kRingPoints], y[3 * kRingPoints], levels[3 * kRingPoints];
    for (int k = 0; k < 3 * kRingPoints; ++k) {
      x[k] = random.Between(-10 * kOne, 70 * kOne);
      y[k] = random.Between(-10 * kOne, 70 * kOne);
    }
    const int count = random.Between(1, 3 * kRingPoints);
    SampleLevels(image.view, x, y, count, levels);
    for (int k = 0; k < count; ++k) {
      ASSERT_EQ(levels[k], ReferenceLevel(image.view, x[k], y[k]))
          << "case " << i << " place " << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, CentroidTest, ::testing::ValuesIn(Targets()),
                         [](const auto& info) { return std::string(hwy::TargetName(info.param)); });

}  // namespace
}  // namespace topotag
