#include "fallback/label.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/canonical.h"
#include "tests/flood_fill.h"
#include "tests/random_image.h"

namespace topotag {
namespace {

std::string Picture(const BitImage& bits) {
  std::string text = std::to_string(bits.width) + "x" + std::to_string(bits.height) + "\n";
  if (bits.width * bits.height > 400) return text;
  for (int y = 0; y < bits.height; ++y) {
    for (int x = 0; x < bits.width; ++x) text += IsWhite(bits, x, y) ? 'o' : '.';
    text += '\n';
  }
  return text;
}

// The runs of each row, one after the other in the order of the rows, with the flood fill's
// numbers.
void ExpectRuns(const BitImage& bits, const FloodFill& slow, const Components& components) {
  ASSERT_EQ(components.width, bits.width);
  ASSERT_EQ(components.height, bits.height);
  const CanonicalComponents canonical(components);
  uint32_t begin = 0;
  for (int y = 0; y < bits.height; ++y) {
    std::vector<int16_t> bound{-1};
    std::vector<uint32_t> number{0};
    bool white = false;
    for (int x = 0; x <= bits.width; ++x) {
      if ((x < bits.width && IsWhite(bits, x, y)) == white) continue;
      white = !white;
      bound.push_back(static_cast<int16_t>(x));
      number.push_back(x < bits.width ? slow.label(x, y) : 0);
    }
    bound.push_back(Components::kOutsideBound);
    const auto row = static_cast<size_t>(y);
    ASSERT_EQ(components.row_begin[row], begin) << "row " << y;
    ASSERT_EQ(components.row_runs[row], number.size()) << "row " << y;
    for (size_t i = 0; i < number.size(); ++i, ++begin) {
      ASSERT_EQ(components.bound[begin], bound[i]) << "row " << y << ", run " << i;
      const uint32_t label = components.label[begin];
      ASSERT_LT(label, components.label_end()) << "row " << y << ", run " << i;
      ASSERT_EQ(canonical.number[label], number[i]) << "row " << y << ", run " << i;
    }
    ASSERT_EQ(components.bound[begin++], bound.back()) << "row " << y;
  }
}

// Slots of the components in random order; 0, none, for about a fifth of them and the outside.
std::vector<uint32_t> RandomSlots(size_t components, Random* random) {
  std::vector<uint32_t> slot(components);
  std::iota(slot.begin(), slot.end(), 0U);
  for (size_t i = 2; i < slot.size(); ++i) {
    std::swap(slot[i], slot[static_cast<size_t>(random->Between(1, static_cast<int>(i)))]);
  }
  for (uint32_t& s : slot) s = random->Chance(20) ? 0 : s;
  return slot;
}

// Sums and boxes over the pixels, of all components but those of slot 0.
void ExpectFeatures(const BitImage& bits, const FloodFill& slow, const Components& components,
                    Random* random) {
  const std::vector<uint32_t> slot = RandomSlots(slow.size(), random);
  std::vector<Feature> expected(slow.size());
  for (int y = 0; y < bits.height; ++y) {
    for (int x = 0; x < bits.width; ++x) {
      const uint32_t s = slot[slow.label(x, y)];
      if (s == 0) continue;
      Feature& f = expected[s];
      f.area += 1;
      f.sum_x += x;
      f.sum_y += y;
      f.min_x = static_cast<uint16_t>(std::min<int>(f.min_x, x));
      f.max_x = static_cast<uint16_t>(std::max<int>(f.max_x, x));
      f.min_y = static_cast<uint16_t>(std::min<int>(f.min_y, y));
      f.max_y = static_cast<uint16_t>(std::max<int>(f.max_y, y));
    }
  }
  std::vector<uint32_t> label_slot(components.label_end());
  const CanonicalComponents canonical(components);
  for (size_t label = 0; label < label_slot.size(); ++label) {
    label_slot[label] = slot[canonical.number[label]];
  }
  // What was in the entries must not matter, and what lies behind them is not touched.
  Feature garbage;
  garbage.sum_x = garbage.sum_y = 1234567;
  garbage.area = garbage.max_x = garbage.max_y = 60000;
  garbage.min_x = garbage.min_y = 1;
  std::vector<Feature> features(expected.size() + 1, garbage);
  scalar::Measure(components, label_slot.data(), expected.size(), features.data());
  for (size_t i = 1; i < expected.size(); ++i) {
    ASSERT_EQ(features[i].area, expected[i].area);
    ASSERT_EQ(features[i].sum_x, expected[i].sum_x);
    ASSERT_EQ(features[i].sum_y, expected[i].sum_y);
    ASSERT_EQ(features[i].min_x, expected[i].min_x);
    ASSERT_EQ(features[i].max_x, expected[i].max_x);
    ASSERT_EQ(features[i].min_y, expected[i].min_y);
    ASSERT_EQ(features[i].max_y, expected[i].max_y);
  }
  ASSERT_EQ(features.back().area, garbage.area);
  ASSERT_EQ(features.back().sum_x, garbage.sum_x);
}

class LabelTest : public ::testing::Test {
 protected:
  // With one workspace for all pictures of a test. The surround test is slow: for small pictures.
  void ExpectLabelled(const BitImage& bits, bool surround) {
    SCOPED_TRACE(Picture(bits));
    const BitImage readable = WithoutNoise(bits);
    const FloodFill slow(readable);
    scalar::Label(bits, &workspace_, &components_);
    ExpectSimpleNumbers(slow.size());
    for (uint32_t i = 0; i < slow.size(); ++i) {
      ASSERT_EQ(components_.white[i], slow.white(i) ? 1 : 0) << "component " << i;
      ASSERT_EQ(components_.parent[i], slow.LeftOfFirstPixel(i)) << "component " << i;
      if (!surround || i == 0) continue;
      ASSERT_EQ(slow.Surrounding(i), std::vector<uint32_t>{components_.parent[i]}) << i;
    }
    ExpectRuns(readable, slow, components_);
    ExpectFeatures(readable, slow, components_, &random_);
  }

  // The scalar backend has one label a component, its canonical number.
  void ExpectSimpleNumbers(size_t count) {
    ASSERT_EQ(components_.ranges.size(), 1U);
    ASSERT_EQ(components_.ranges[0].begin, 0U);
    ASSERT_EQ(components_.ranges[0].end, count);
    for (uint32_t i = 0; i < count; ++i) ASSERT_EQ(components_.root[i], i);
  }

  std::vector<uint32_t> Parents() {
    return {components_.parent.data(), components_.parent.data() + components_.label_end()};
  }

  BitImage RandomBits(int width, int height, int density, int scale) {
    const int columns = (width + scale - 1) / scale, rows = (height + scale - 1) / scale;
    std::vector<bool> cells(static_cast<size_t>(columns) * static_cast<size_t>(rows));
    for (size_t i = 0; i < cells.size(); ++i) cells[i] = random_.Chance(density);
    return MakeBits(width, height, [&](int x, int y) {
      return cells[static_cast<size_t>(y / scale * columns + x / scale)];
    });
  }

  scalar::LabelWorkspace workspace_;
  Components components_;
  Random random_{1};
};

TEST_F(LabelTest, SmallRandomPictures) {
  for (int i = 0; i < 10000 && !HasFatalFailure(); ++i) {
    const int width = random_.Between(1, 11), height = random_.Between(1, 11);
    ExpectLabelled(RandomBits(width, height, 10 + i % 9 * 10, 1), true);
  }
}

TEST_F(LabelTest, AllPicturesOfFourByFour) {
  for (int picture = 0; picture < 1 << 16 && !HasFatalFailure(); ++picture) {
    ExpectLabelled(MakeBits(4, 4, [=](int x, int y) { return picture >> (4 * y + x) & 1; }), false);
  }
}

TEST_F(LabelTest, RandomPicturesAroundTheWordSize) {
  for (const int width : {1, 2, 62, 63, 64, 65, 127, 128, 129, 191, 193}) {
    for (int density = 10; density <= 90 && !HasFatalFailure(); density += 10) {
      ExpectLabelled(RandomBits(width, 1, density, 1), false);
      ExpectLabelled(RandomBits(width, 40, density, 1), false);
      ExpectLabelled(RandomBits(width, 40, density, 3), false);
    }
  }
}

bool Spiral(int x, int y, int width, int height) {
  // Square rings, each opened at its upper left and led into the next.
  const int depth = std::min({x, y, width - 1 - x, height - 1 - y});
  const bool gate = x == depth && y == depth + 1 && depth % 2 == 0;
  const bool bridge = x == depth && y == depth + 1 && depth % 2 == 1;
  return (depth % 2 == 0) != (gate || bridge);
}

TEST_F(LabelTest, StructuredPictures) {
  using Rule = std::function<bool(int, int, int, int)>;
  const std::vector<Rule> rules = {
      Spiral,
      [](int x, int y, int w, int h) { return !Spiral(x, y, w, h); },
      [](int x, int y, int, int) { return x % 2 == 0 || y == 0; },  // combs
      [](int x, int y, int, int h) { return x % 2 == 0 || y == h - 1; },
      [](int x, int y, int w, int) { return y % 2 == 0 || x == w - 1; },
      [](int x, int y, int w, int) { return y % 2 == 0 || x == (y % 4 == 1 ? 0 : w - 1); },
      [](int x, int y, int w, int h) {  // nested rings
        return std::min({x, y, w - 1 - x, h - 1 - y}) % 2 == 0;
      },
      [](int x, int y, int w, int h) {
        return (std::abs(x - w / 2) + std::abs(y - h / 2)) % 3 == 0;
      },
      [](int x, int y, int, int) { return (x + y) % 2 == 0; },  // checkerboards
      [](int x, int y, int, int) { return (x + y) % 2 == 1; },
      [](int, int, int, int) { return true; },
      [](int, int, int, int) { return false; },
      [](int x, int y, int w, int h) { return x == w / 2 && y == h / 2; },
      [](int x, int y, int w, int h) { return x != w / 2 || y != h / 2; },
      [](int x, int y, int w, int h) { return x == w - 1 && y == h - 1; },
  };
  // In large pictures lines of one pixel are noise, lines of three are not.
  for (const int scale : {1, 3}) {
    for (const int width : {1, 2, 3, 9, 63, 64, 65, 127, 128, 129}) {
      for (const int height : {1, 2, 3, 9, 24, 65}) {
        for (const Rule& rule : rules) {
          if (HasFatalFailure()) return;
          const int columns = (width + scale - 1) / scale, rows = (height + scale - 1) / scale;
          const auto white = [&](int x, int y) {
            return rule(x / scale, y / scale, columns, rows);
          };
          ExpectLabelled(MakeBits(width, height, white), width <= 9 && height <= 9);
        }
      }
    }
  }
}

TEST_F(LabelTest, LongestRowsAndColumns) {
  for (const auto& [width, height] : {std::pair<int, int>{kMaxImageSide, 3}, {3, kMaxImageSide}}) {
    ExpectLabelled(RandomBits(width, height, 60, 1), false);
    ExpectLabelled(MakeBits(width, height, [](int x, int y) { return (x + y) % 2; }), false);
    ExpectLabelled(MakeBits(width, height, [](int, int) { return true; }), false);
  }
}

TEST_F(LabelTest, NestedRingsAreADeepChain) {
  const int side = 2 * 65 * 3;  // rings of 3 pixels: narrower ones are noise
  const BitImage bits = MakeBits(side, side, [](int x, int y) {
    return std::min({x, y, side - 1 - x, side - 1 - y}) / 3 % 2 == 1;
  });
  scalar::Label(bits, &workspace_, &components_);
  ASSERT_EQ(components_.label_end(), 65U);
  for (uint32_t i = 1; i < 65; ++i) {
    EXPECT_EQ(components_.parent[i], i - 1);
    EXPECT_EQ(components_.white[i], i % 2);
  }
}

// Black goes across corners, white does not.
TEST_F(LabelTest, Connectivity) {
  const BitImage cross =
      MakeBits(4, 4, [](int x, int y) { return !(x == 1 && y == 1) && !(x == 2 && y == 2); });
  scalar::Label(cross, &workspace_, &components_);
  EXPECT_EQ(Parents(), (std::vector<uint32_t>{0, 0, 1}));
  const BitImage bar =
      MakeBits(4, 4, [](int x, int y) { return (x == 1 && y == 1) || (x == 2 && y == 2); });
  scalar::Label(bar, &workspace_, &components_);
  EXPECT_EQ(Parents(), (std::vector<uint32_t>{0, 0, 0}));
  // The black pixels at the border, even at corners alone, are the outside.
  const BitImage corner = MakeBits(3, 3, [](int x, int y) { return !(x == 0 && y == 0); });
  scalar::Label(corner, &workspace_, &components_);
  EXPECT_EQ(Parents(), (std::vector<uint32_t>{0, 0}));
}

TEST_F(LabelTest, AsManyComponentsAsOpenCv) {
  for (int i = 0; i < 9; ++i) {
    const BitImage bits = WithoutNoise(RandomBits(611 + 50 * i, 433, 10 + 10 * i, 1 + i % 3));
    cv::Mat white(bits.height + 2, bits.width + 2, CV_8U, cv::Scalar(0));
    for (int y = 0; y < bits.height; ++y) {
      for (int x = 0; x < bits.width; ++x) white.at<uint8_t>(y + 1, x + 1) = IsWhite(bits, x, y);
    }
    cv::Mat labels;
    const int whites = cv::connectedComponents(white, labels, 4) - 1;
    const int blacks = cv::connectedComponents(1 - white, labels, 8) - 1;
    scalar::Label(bits, &workspace_, &components_);
    const CanonicalComponents canonical(components_);
    EXPECT_EQ(std::accumulate(canonical.white.begin(), canonical.white.end(), 0), whites);
    EXPECT_EQ(static_cast<int>(canonical.white.size()), whites + blacks);
  }
}

// With one workspace for pictures that shrink and grow.
TEST_F(LabelTest, WorkspacesKeepNothing) {
  const BitImage large = RandomBits(300, 200, 45, 3), small = RandomBits(40, 9, 60, 1);
  for (const BitImage* bits : {&large, &small, &large, &small}) ExpectLabelled(*bits, false);
}

// For pictures and comparisons: the component of each pixel.
TEST_F(LabelTest, CanonicalLabelsAreThoseOfTheFloodFill) {
  for (int i = 0; i < 200; ++i) {
    const int width = random_.Between(1, 140), height = random_.Between(1, 40);
    const BitImage bits = WithoutNoise(RandomBits(width, height, 60, 1 + i % 3));
    const FloodFill slow(bits);
    scalar::Label(bits, &workspace_, &components_);
    const std::vector<uint32_t> labels = CanonicalLabels(components_);
    ASSERT_EQ(labels.size(), static_cast<size_t>(bits.width) * static_cast<size_t>(bits.height));
    for (int y = 0; y < bits.height; ++y) {
      for (int x = 0; x < bits.width; ++x) {
        ASSERT_EQ(labels[static_cast<size_t>(y * bits.width + x)], slow.label(x, y));
      }
    }
  }
}

// Labels of a backend with several threads: gaps between the ranges, several labels a component.
TEST(CanonicalTest, GapsAndJoinedLabels) {
  Components components;
  components.width = 4;
  components.height = 2;
  components.ranges = {{0, 3}, {10, 13}};
  const uint32_t root[] = {0, 1, 0, 9, 9, 9, 9, 9, 9, 9, 1, 11, 12};
  const uint32_t parent[] = {0, 0, 0, 9, 9, 9, 9, 9, 9, 9, 9, 1, 11};
  const uint8_t white[] = {0, 1, 0, 9, 9, 9, 9, 9, 9, 9, 9, 0, 1};
  components.root.Reserve(13);
  components.parent.Reserve(13);
  components.white.Reserve(13);
  std::copy_n(root, 13, components.root.data());
  std::copy_n(parent, 13, components.parent.data());
  std::copy_n(white, 13, components.white.data());
  EXPECT_EQ(components.label_end(), 13U);
  const CanonicalComponents canonical(components);
  EXPECT_EQ(canonical.parent, (std::vector<uint32_t>{0, 0, 1, 2}));
  EXPECT_EQ(canonical.white, (std::vector<uint8_t>{0, 1, 0, 1}));
  ASSERT_EQ(canonical.number.size(), 13U);
  for (const auto& [label, number] :
       {std::pair<size_t, uint32_t>{0, 0}, {1, 1}, {2, 0}, {10, 1}, {11, 2}, {12, 3}}) {
    EXPECT_EQ(canonical.number[label], number) << label;
  }
}

}  // namespace
}  // namespace topotag
