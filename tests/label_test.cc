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

#include "tests/random_image.h"

namespace topotag {
namespace {

// Components by flood filling the picture with a border of one black pixel around it, in raster
// order: so the outside gets 0, and the others the canonical numbers.
class FloodFill {
 public:
  explicit FloodFill(const BitImage& bits) : width_(bits.width + 2), height_(bits.height + 2) {
    white_.resize(static_cast<size_t>(width_) * static_cast<size_t>(height_));
    for (int y = 0; y < bits.height; ++y) {
      for (int x = 0; x < bits.width; ++x) white_[At(x, y)] = IsWhite(bits, x, y);
    }
    label_.assign(white_.size(), -1);
    for (size_t at = 0; at < white_.size(); ++at) {
      if (label_[at] >= 0) continue;
      Fill(at, static_cast<int>(first_.size()));
      first_.push_back(at);
    }
  }

  size_t size() const { return first_.size(); }
  uint32_t label(int x, int y) const { return static_cast<uint32_t>(label_[At(x, y)]); }
  bool white(size_t component) const { return white_[first_[component]]; }
  uint32_t LeftOfFirstPixel(size_t component) const {
    return component == 0 ? 0 : static_cast<uint32_t>(label_[first_[component] - 1]);
  }

  // Components that share an edge with `component` and without whose pixels no way leads from it
  // to the outside: one step to a side, or across a corner within a black component. The outside
  // itself where there is no other.
  std::vector<uint32_t> Surrounding(size_t component) const {
    std::vector<uint32_t> around;
    bool outside = false;
    for (const int other : Neighbours(static_cast<int>(component))) {
      if (other == 0) outside = true;
      if (other != 0 && !Escapes(static_cast<int>(component), other)) {
        around.push_back(static_cast<uint32_t>(other));
      }
    }
    if (around.empty() && outside) around.push_back(0);
    return around;
  }

 private:
  size_t At(int x, int y) const {
    return static_cast<size_t>(y + 1) * static_cast<size_t>(width_) + static_cast<size_t>(x + 1);
  }

  // Calls visit(neighbour, is_diagonal) for those of the eight that exist.
  template <typename Visit>
  void ForNeighbours(size_t at, Visit visit) const {
    const int x = static_cast<int>(at) % width_, y = static_cast<int>(at) / width_;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (x + dx < 0 || x + dx >= width_ || y + dy < 0 || y + dy >= height_) continue;
        if (dx != 0 || dy != 0) visit(At(x + dx - 1, y + dy - 1), dx != 0 && dy != 0);
      }
    }
  }

  void Fill(size_t start, int label) {
    std::vector<size_t> stack{start};
    label_[start] = label;
    while (!stack.empty()) {
      const size_t at = stack.back();
      stack.pop_back();
      ForNeighbours(at, [&](size_t next, bool diagonal) {
        if (label_[next] >= 0 || white_[next] != white_[at] || (diagonal && white_[at])) return;
        label_[next] = label;
        stack.push_back(next);
      });
    }
  }

  std::vector<int> Neighbours(int component) const {
    std::vector<int> found;
    for (size_t at = 0; at < label_.size(); ++at) {
      if (label_[at] != component) continue;
      ForNeighbours(at, [&](size_t next, bool diagonal) {
        if (!diagonal && label_[next] != component) found.push_back(label_[next]);
      });
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  bool Escapes(int component, int removed) const {
    std::vector<bool> seen(label_.size());
    std::vector<size_t> stack{first_[static_cast<size_t>(component)]};
    seen[stack[0]] = true;
    while (!stack.empty()) {
      const size_t at = stack.back();
      stack.pop_back();
      if (label_[at] == 0) return true;
      ForNeighbours(at, [&](size_t next, bool diagonal) {
        if (seen[next] || label_[next] == removed) return;
        if (diagonal && (white_[at] || label_[next] != label_[at])) return;
        seen[next] = true;
        stack.push_back(next);
      });
    }
    return false;
  }

  int width_;
  int height_;
  std::vector<bool> white_;
  std::vector<int> label_;
  std::vector<size_t> first_;
};

std::string Picture(const BitImage& bits) {
  std::string text = std::to_string(bits.width) + "x" + std::to_string(bits.height) + "\n";
  if (bits.width * bits.height > 400) return text;
  for (int y = 0; y < bits.height; ++y) {
    for (int x = 0; x < bits.width; ++x) text += IsWhite(bits, x, y) ? 'o' : '.';
    text += '\n';
  }
  return text;
}

// The layout of the runs: transitions where the colour changes, and labels as the flood fill's.
void ExpectRuns(const BitImage& bits, const FloodFill& slow, const Components& components) {
  ASSERT_EQ(components.width, bits.width);
  ASSERT_EQ(components.height, bits.height);
  const auto height = static_cast<size_t>(bits.height);
  ASSERT_EQ(components.row_begin.size(), height + 1);
  ASSERT_EQ(components.row_begin[0], 0U);
  ASSERT_EQ(components.row_begin[height], components.transition.size());
  ASSERT_EQ(components.label.size(), components.transition.size() + height);
  for (int y = 0; y < bits.height; ++y) {
    std::vector<uint16_t> transition;
    std::vector<uint32_t> label{0};
    bool white = false;
    for (int x = 0; x <= bits.width; ++x) {
      if ((x < bits.width && IsWhite(bits, x, y)) == white) continue;
      white = !white;
      transition.push_back(static_cast<uint16_t>(x));
      label.push_back(x < bits.width ? slow.label(x, y) : 0);
    }
    const uint32_t begin = components.row_begin[static_cast<size_t>(y)];
    const uint32_t end = components.row_begin[static_cast<size_t>(y) + 1];
    ASSERT_EQ(end - begin, transition.size()) << "row " << y;
    ASSERT_EQ(components.run_begin(y), begin + static_cast<size_t>(y));
    ASSERT_TRUE(
        std::equal(transition.begin(), transition.end(), components.transition.begin() + begin))
        << "row " << y;
    ASSERT_TRUE(std::equal(label.begin(), label.end(), components.label.begin() + begin + y))
        << "row " << y;
  }
}

// Sums and boxes over the pixels, of all components but those of slot 0.
void ExpectFeatures(const BitImage& bits, const FloodFill& slow, const Components& components,
                    Random* random) {
  std::vector<uint32_t> slot(slow.size());
  std::iota(slot.begin(), slot.end(), 1U);
  for (size_t i = 1; i < slot.size(); ++i) {
    std::swap(slot[i], slot[static_cast<size_t>(random->Below(static_cast<int>(i) + 1))]);
  }
  for (uint32_t& s : slot) s = random->Chance(20) ? 0 : s;
  std::vector<Feature> expected(slow.size() + 1), features(slow.size() + 1);
  for (int y = 0; y < bits.height; ++y) {
    for (int x = 0; x < bits.width; ++x) {
      Feature& f = expected[slot[slow.label(x, y)]];
      f.area += 1;
      f.sum_x += x;
      f.sum_y += y;
      f.min_x = static_cast<uint16_t>(std::min<int>(f.min_x, x));
      f.max_x = static_cast<uint16_t>(std::max<int>(f.max_x, x));
      f.min_y = static_cast<uint16_t>(std::min<int>(f.min_y, y));
      f.max_y = static_cast<uint16_t>(std::max<int>(f.max_y, y));
    }
  }
  expected[0] = Feature();
  scalar::Measure(components, slot, &features);
  for (size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(features[i].area, expected[i].area);
    ASSERT_EQ(features[i].sum_x, expected[i].sum_x);
    ASSERT_EQ(features[i].sum_y, expected[i].sum_y);
    ASSERT_EQ(features[i].min_x, expected[i].min_x);
    ASSERT_EQ(features[i].max_x, expected[i].max_x);
    ASSERT_EQ(features[i].min_y, expected[i].min_y);
    ASSERT_EQ(features[i].max_y, expected[i].max_y);
  }
}

class LabelTest : public ::testing::Test {
 protected:
  // With one workspace for all pictures of a test. The surround test is slow: for small pictures.
  void ExpectLabelled(const BitImage& bits, bool surround) {
    SCOPED_TRACE(Picture(bits));
    const FloodFill slow(bits);
    scalar::Label(bits, &workspace_, &components_);
    ASSERT_EQ(components_.size(), slow.size());
    ASSERT_EQ(components_.white.size(), slow.size());
    for (size_t i = 0; i < slow.size(); ++i) {
      ASSERT_EQ(components_.white[i], slow.white(i) ? 1 : 0) << "component " << i;
      ASSERT_EQ(components_.parent[i], slow.LeftOfFirstPixel(i)) << "component " << i;
      if (!surround || i == 0) continue;
      ASSERT_EQ(slow.Surrounding(i), std::vector<uint32_t>{components_.parent[i]}) << i;
    }
    ExpectRuns(bits, slow, components_);
    ExpectFeatures(bits, slow, components_, &random_);
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
    ExpectLabelled(RandomBits(random_.Between(1, 11), random_.Between(1, 11), 10 + i % 9 * 10, 1),
                   true);
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
  for (const int width : {1, 2, 3, 9, 63, 64, 65, 127, 128, 129}) {
    for (const int height : {1, 2, 3, 9, 24, 65}) {
      for (const Rule& rule : rules) {
        if (HasFatalFailure()) return;
        ExpectLabelled(
            MakeBits(width, height, [&](int x, int y) { return rule(x, y, width, height); }),
            width <= 9 && height <= 9);
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
  const int side = 129;
  const BitImage bits = MakeBits(side, side, [](int x, int y) {
    return std::min({x, y, side - 1 - x, side - 1 - y}) % 2 == 1;
  });
  scalar::Label(bits, &workspace_, &components_);
  ASSERT_EQ(components_.size(), 65U);
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
  EXPECT_EQ(components_.parent, (std::vector<uint32_t>{0, 0, 1}));
  const BitImage bar =
      MakeBits(4, 4, [](int x, int y) { return (x == 1 && y == 1) || (x == 2 && y == 2); });
  scalar::Label(bar, &workspace_, &components_);
  EXPECT_EQ(components_.parent, (std::vector<uint32_t>{0, 0, 0}));
  // The black pixels at the border, even at corners alone, are the outside.
  const BitImage corner = MakeBits(3, 3, [](int x, int y) { return !(x == 0 && y == 0); });
  scalar::Label(corner, &workspace_, &components_);
  EXPECT_EQ(components_.parent, (std::vector<uint32_t>{0, 0}));
}

TEST_F(LabelTest, AsManyComponentsAsOpenCv) {
  for (int i = 0; i < 9; ++i) {
    const BitImage bits = RandomBits(611 + 50 * i, 433, 10 + 10 * i, 1 + i % 3);
    cv::Mat white(bits.height + 2, bits.width + 2, CV_8U, cv::Scalar(0));
    for (int y = 0; y < bits.height; ++y) {
      for (int x = 0; x < bits.width; ++x) white.at<uint8_t>(y + 1, x + 1) = IsWhite(bits, x, y);
    }
    cv::Mat labels;
    const int whites = cv::connectedComponents(white, labels, 4) - 1;
    const int blacks = cv::connectedComponents(1 - white, labels, 8) - 1;
    scalar::Label(bits, &workspace_, &components_);
    EXPECT_EQ(std::accumulate(components_.white.begin(), components_.white.end(), 0), whites);
    EXPECT_EQ(static_cast<int>(components_.size()), whites + blacks);
  }
}

TEST_F(LabelTest, WorkspacesKeepNothing) {
  const BitImage large = RandomBits(300, 200, 45, 1), small = RandomBits(40, 9, 60, 1);
  for (const BitImage* bits : {&large, &small, &large, &small}) {
    scalar::LabelWorkspace fresh_workspace;
    Components fresh;
    scalar::Label(*bits, &fresh_workspace, &fresh);
    scalar::Label(*bits, &workspace_, &components_);
    EXPECT_EQ(components_.width, fresh.width);
    EXPECT_EQ(components_.height, fresh.height);
    EXPECT_EQ(components_.row_begin, fresh.row_begin);
    EXPECT_EQ(components_.transition, fresh.transition);
    EXPECT_EQ(components_.label, fresh.label);
    EXPECT_EQ(components_.parent, fresh.parent);
    EXPECT_EQ(components_.white, fresh.white);
  }
}

}  // namespace
}  // namespace topotag
