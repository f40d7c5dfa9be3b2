#include "fallback/threshold.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "fallback/binarize.h"
#include "tests/random_image.h"

namespace topotag {
namespace {

int FloorDivide(int64_t a, int64_t b) {
  return static_cast<int>(a / b - (a % b != 0 && (a < 0) != (b < 0)));
}

// To the nearest whole number, halves up.
int RoundDivide(int64_t a, int64_t b) { return FloorDivide(2 * a + b, 2 * b); }

int TilesAlong(int pixels) { return (pixels + 15) / 16; }

// The default preset by its definition, one corner at a time.
class SlowDefault {
 public:
  SlowDefault(const ImageView& image, const ThresholdParams& params)
      : image_(image),
        params_(params),
        cols_(TilesAlong(image.width) + 1),
        rows_(TilesAlong(image.height) + 1) {
    for (int r = 0; r < rows_; ++r) {
      for (int c = 0; c < cols_; ++c) extremes_.push_back(Extremes(r, c));
    }
  }

  int Value(int row, int col) const {
    // The corner itself, or the first coarser cell around it that knows.
    for (int level = 0; (1 << level) < 2 * std::max(cols_, rows_); ++level) {
      if (const auto value = Level(level, row >> level, col >> level)) return *value;
    }
    return 0;
  }

  // Bounds of the thresholds in a tile: in one without contrast, what makes all of it white or
  // black.
  std::pair<int, int> Bounds(int row, int col) const {
    const Range range = TileExtremes(row, col);
    if (range.hi - range.lo >= params_.min_contrast) return {0, 255};
    const double corners =
        (Value(row, col) + Value(row, col + 1) + Value(row + 1, col) + Value(row + 1, col + 1)) /
        8.0;
    const double middle = (range.lo + range.hi) / 2.0;
    return middle >= corners / 4 ? std::pair{0, 0} : std::pair{255, 255};
  }

 private:
  struct Range {
    int lo = 255;
    int hi = 0;
  };

  const Range& At(int row, int col) const {
    return extremes_[static_cast<size_t>(row * cols_ + col)];
  }

  // Of the vertical pair means of all pixels in a tile.
  Range TileExtremes(int row, int col) const {
    Range range;
    for (int y = 16 * row; y < std::min(16 * row + 16, image_.height); ++y) {
      const int partner = std::min(y % 2 == 0 ? y + 1 : y - 1, image_.height - 1);
      for (int x = 16 * col; x < std::min(16 * col + 16, image_.width); ++x) {
        const int sum = image_.row(y)[x] + image_.row(partner)[x];
        range.lo = std::min(range.lo, (sum + sum % 2) / 2);
        range.hi = std::max(range.hi, (sum + sum % 2) / 2);
      }
    }
    return range;
  }

  // Of the up to four tiles around the corner.
  Range Extremes(int row, int col) const {
    Range range;
    for (int r = std::max(row - 1, 0); r < std::min(row + 1, rows_ - 1); ++r) {
      for (int c = std::max(col - 1, 0); c < std::min(col + 1, cols_ - 1); ++c) {
        const Range tile = TileExtremes(r, c);
        range.lo = std::min(range.lo, tile.lo);
        range.hi = std::max(range.hi, tile.hi);
      }
    }
    return range;
  }

  // A cell of the pyramid: nothing, or the largest that its children know.
  std::optional<int> Level(int level, int row, int col) const {
    if (((row << level) >= rows_) || ((col << level) >= cols_)) return std::nullopt;
    if (level == 0) {
      const Range range = At(row, col);
      const int contrast = range.hi - range.lo;
      if (contrast < params_.min_contrast) return std::nullopt;
      return FloorDivide(8 * (16 * range.lo + params_.contrast_sixteenths * contrast), 16);
    }
    const auto [known, is_new] = known_.try_emplace({level, row, col});
    if (!is_new) return known->second;
    for (int child = 0; child < 4; ++child) {
      const auto value = Level(level - 1, 2 * row + child / 2, 2 * col + child % 2);
      if (value) known->second = std::max(known->second.value_or(0), *value);
    }
    return known->second;
  }

  ImageView image_;
  ThresholdParams params_;
  int cols_;
  int rows_;
  std::vector<Range> extremes_;
  mutable std::map<std::array<int, 3>, std::optional<int>> known_;
};

// The paper's preset by its definition.
class SlowPaper {
 public:
  SlowPaper(const ImageView& image, const ThresholdParams& params)
      : image_(image),
        params_(params),
        block_cols_((image.width + 3) / 4),
        block_rows_((image.height + 3) / 4) {
    for (int r = 0; r < block_rows_; ++r) {
      for (int c = 0; c < block_cols_; ++c) blocks_.push_back(std::max(Block(r, c), params.alpha));
    }
    for (int r = 0; r < block_rows_; r += 8) {
      samples_.emplace_back();
      for (int c = 0; c < block_cols_; c += 8) samples_.back().push_back(Sample(r, c));
    }
  }

  // Sample k stands at pixel 32 k + 1.5, corner j at 16 j - 0.5; every sample's weight falls
  // linearly to 0 at its neighbours, and the samples at the ends reach to infinity.
  int Value(int row, int col) const {
    int64_t sum = 0;
    for (size_t r = 0; r < samples_.size(); ++r) {
      for (size_t c = 0; c < samples_[r].size(); ++c) {
        sum += int64_t{samples_[r][c]} * Weight(row, r, samples_.size()) *
               Weight(col, c, samples_[r].size());
      }
    }
    return RoundDivide(sum, 32 * 32);
  }

  std::pair<int, int> Bounds(int, int) const { return {0, 255}; }

 private:
  // In 32ths.
  static int Weight(int corner, size_t sample, size_t samples) {
    const int twice_first = 3, twice_last = 64 * (static_cast<int>(samples) - 1) + 3;
    const int twice_at = std::clamp(32 * corner - 1, twice_first, twice_last);
    return std::max(0, 32 - std::abs(twice_at - (64 * static_cast<int>(sample) + 3)) / 2);
  }

  int Block(int row, int col) const {
    int64_t sum = 0, count = 0;
    for (int y = 4 * row; y < 4 * row + 4 && y < image_.height; ++y) {
      for (int x = 4 * col; x < 4 * col + 4 && x < image_.width; ++x, ++count) {
        sum += image_.row(y)[x];
      }
    }
    return RoundDivide(sum, count);
  }

  int Sample(int row, int col) const {
    int64_t sum = 0, count = 0;
    for (int r = row - 2; r <= row + 2; ++r) {
      for (int c = col - 2; c <= col + 2; ++c) {
        if (r < 0 || c < 0 || r >= block_rows_ || c >= block_cols_) continue;
        sum += blocks_[static_cast<size_t>(r * block_cols_ + c)];
        ++count;
      }
    }
    return std::max(RoundDivide(8 * params_.bin_factor_percent * sum, 100 * count),
                    8 * params_.beta);
  }

  ImageView image_;
  ThresholdParams params_;
  int block_cols_;
  int block_rows_;
  std::vector<int> blocks_;
  std::vector<std::vector<int>> samples_;
};

template <typename Slow>
bool ExpectSame(const Slow& slow, const ThresholdGrid& grid, const ImageCase& c) {
  EXPECT_EQ(grid.cols, TilesAlong(c.width) + 1) << c;
  EXPECT_EQ(grid.rows, TilesAlong(c.height) + 1) << c;
  EXPECT_EQ(grid.value.size(), static_cast<size_t>(grid.cols) * static_cast<size_t>(grid.rows));
  for (int row = 0; row < grid.rows; ++row) {
    for (int col = 0; col < grid.cols; ++col) {
      EXPECT_EQ(slow.Value(row, col), grid.row(row)[col]) << "(" << row << ", " << col << ") " << c;
      if (::testing::Test::HasFailure()) return false;
    }
  }
  const auto tiles = static_cast<size_t>(grid.cols - 1) * static_cast<size_t>(grid.rows - 1);
  EXPECT_EQ(grid.floor.size(), tiles) << c;
  EXPECT_EQ(grid.ceiling.size(), tiles) << c;
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int col = 0; col + 1 < grid.cols; ++col) {
      const size_t tile =
          static_cast<size_t>(row) * static_cast<size_t>(grid.cols - 1) + static_cast<size_t>(col);
      const std::pair<int, int> bounds{grid.floor[tile], grid.ceiling[tile]};
      EXPECT_EQ(slow.Bounds(row, col), bounds) << "tile (" << row << ", " << col << ") " << c;
      if (::testing::Test::HasFailure()) return false;
    }
  }
  return true;
}

ThresholdGrid Map(const ImageView& image, const ThresholdParams& params = {}) {
  scalar::ThresholdWorkspace workspace;
  ThresholdGrid grid;
  scalar::ThresholdMap(image, params, &workspace, &grid);
  return grid;
}

ThresholdParams PaperParams() {
  ThresholdParams params;
  params.preset = Preset::kPaper;
  return params;
}

TEST(ThresholdTest, DefaultMapIsItsDefinition) {
  scalar::ThresholdWorkspace workspace;  // one for all sizes: its contents must not matter
  ThresholdGrid grid;
  const int sixteenths[] = {7, 8, 6, 5, 11};
  const int contrasts[] = {20, 20, 5, 1, 60};
  for (const ImageCase& c : AllCases()) {
    const PaddedImage image = MakeImage(c);
    ThresholdParams params;
    params.contrast_sixteenths = sixteenths[c.seed / 2 % 5];
    params.min_contrast = contrasts[c.seed / 2 / 5 % 5];
    scalar::ThresholdMap(image.view(), params, &workspace, &grid);
    if (!ExpectSame(SlowDefault(image.view(), params), grid, c)) return;
  }
}

TEST(ThresholdTest, PaperMapIsItsDefinition) {
  scalar::ThresholdWorkspace workspace;
  ThresholdGrid grid;
  for (const ImageCase& c : AllCases()) {
    const PaddedImage image = MakeImage(c);
    ThresholdParams params = PaperParams();
    if (c.seed % 3 == 0) {
      params.alpha = 0;
      params.beta = 0;
      params.bin_factor_percent = c.seed % 2 == 0 ? 100 : 83;
    }
    scalar::ThresholdMap(image.view(), params, &workspace, &grid);
    if (!ExpectSame(SlowPaper(image.view(), params), grid, c)) return;
  }
}

TEST(ThresholdTest, LargeMapsAreTheirDefinitions) {
  for (uint64_t seed = 1; seed < 12; ++seed) {
    // Few corners with contrast: the others take theirs from far up the pyramid.
    const ImageCase c{500 + static_cast<int>(41 * seed), 330, 5, Content::kBlobs, seed};
    const PaddedImage image = MakeImage(c);
    if (!ExpectSame(SlowDefault(image.view(), {}), Map(image.view()), c)) return;
    if (!ExpectSame(SlowPaper(image.view(), PaperParams()), Map(image.view(), PaperParams()), c)) {
      return;
    }
  }
}

TEST(ThresholdTest, ReadsNothingBesideTheImage) {
  for (const ImageCase& c : AllCases()) {
    if (c.padding == 0 || c.width > 200 || c.height > 200) continue;
    PaddedImage image = MakeImage(c);
    for (const ThresholdParams& params : {ThresholdParams(), PaperParams()}) {
      const ThresholdGrid grid = Map(image.view(), params);
      for (uint64_t garbage = 1; garbage <= 2; ++garbage) {
        image.FillPadding(c.seed + 1000 * garbage);
        const ThresholdGrid again = Map(image.view(), params);
        ASSERT_EQ(grid.value, again.value) << c;
        ASSERT_EQ(grid.floor, again.floor) << c;
        ASSERT_EQ(grid.ceiling, again.ceiling) << c;
      }
    }
  }
}

TEST(ThresholdTest, StaysWithinItsBounds) {
  for (const ImageCase& c : AllCases()) {
    const PaddedImage image = MakeImage(c);
    for (const uint16_t value : Map(image.view()).value) ASSERT_LE(value, kMaxThreshold) << c;
    for (const uint16_t value : Map(image.view(), PaperParams()).value) {
      ASSERT_GE(value, 50 << kThresholdShift) << c;
      ASSERT_LE(value, 8 * 95 * 255 / 100 + 1) << c;
    }
  }
}

TEST(ThresholdTest, ContrastDecidesFromTwentyLevelsOn) {
  PaddedImage image(32, 32, 0);
  for (int y = 0; y < 32; ++y) std::fill_n(image.row(y), 32, uint8_t{100});
  image.row(4)[20] = image.row(5)[20] = 119;
  for (const uint16_t value : Map(image.view()).value) EXPECT_EQ(value, 0);
  image.row(4)[20] = image.row(5)[20] = 120;
  for (const uint16_t value : Map(image.view()).value) EXPECT_EQ(value, 8 * 100 + 8 * 20 * 7 / 16);
  // A single pixel counts half, rounded up.
  image.row(5)[20] = 100;
  image.row(4)[20] = 138;
  for (const uint16_t value : Map(image.view()).value) EXPECT_EQ(value, 0);
  image.row(4)[20] = 139;
  for (const uint16_t value : Map(image.view()).value) EXPECT_EQ(value, 8 * 100 + 8 * 20 * 7 / 16);
}

TEST(ThresholdTest, CornersWithoutContrastTakeTheLargestNearThem) {
  // One row of 11 tiles. Three pairs of them have contrast, around corners 0, 4 and 10.
  PaddedImage image(176, 16, 0);
  for (int y = 0; y < 16; ++y) {
    std::fill_n(image.row(y), 176, uint8_t{128});
    image.row(y)[0] = 255;  // corners 0 and 1
    image.row(y)[64] = 48;  // corners 4 and 5
    image.row(y)[175] = 8;  // corners 10 and 11
  }
  const int high = 8 * 128 + 127 * 7 / 2, middle = 8 * 48 + 80 * 7 / 2, low = 8 * 8 + 120 * 7 / 2;
  const int expected[] = {high,   high,   high, high, middle, middle,
                          middle, middle, low,  low,  low,    low};
  const ThresholdGrid grid = Map(image.view());
  for (int row = 0; row < 2; ++row) {
    for (int col = 0; col < 12; ++col) EXPECT_EQ(grid.row(row)[col], expected[col]) << col;
  }
}

// Where the middle of its extremes is below the mean of its corners: black.
TEST(ThresholdTest, FlatTilesAreOfOneColour) {
  const struct {
    int dark, bright, lo, hi;
    bool black;
  } table[] = {
      {0, 255, 111, 111, true},    // the corners are at 111.5
      {0, 255, 112, 112, false},   //
      {0, 255, 111, 112, false},   // at the threshold: white
      {0, 255, 103, 119, true},    //
      {0, 255, 103, 120, false},   //
      {0, 255, 102, 121, false},   // as much below as above, 19 levels
      {0, 255, 101, 120, true},    //
      {0, 255, 0, 0, true},        //
      {0, 255, 255, 255, false},   //
      {235, 255, 243, 243, true},  // 243.75
      {235, 255, 244, 244, false},
  };
  for (const auto& t : table) {
    // Three tiles: the first is half dark and half bright, the others alternate between lo and hi
    // every two rows. The corners right of the second tile do not see the first.
    PaddedImage image(48, 16, 0);
    for (int y = 0; y < 16; ++y) {
      std::fill_n(image.row(y), 8, static_cast<uint8_t>(t.dark));
      std::fill_n(image.row(y) + 8, 8, static_cast<uint8_t>(t.bright));
      std::fill_n(image.row(y) + 16, 32, static_cast<uint8_t>(y / 2 % 2 == 0 ? t.lo : t.hi));
    }
    const ThresholdGrid grid = Map(image.view());
    const int threshold = 8 * t.dark + (t.bright - t.dark) * 7 / 2;
    for (const uint16_t value : grid.value) EXPECT_EQ(value, threshold);
    const uint8_t floor = t.black ? 255 : 0, ceiling = t.black ? 255 : 0;
    EXPECT_EQ(grid.floor, std::vector<uint8_t>({0, floor, floor})) << t.lo << ".." << t.hi;
    EXPECT_EQ(grid.ceiling, std::vector<uint8_t>({255, ceiling, ceiling})) << t.lo << ".." << t.hi;
  }
}

TEST(ThresholdTest, TilesAreFlatBelowTwentyLevels) {
  for (const int levels : {19, 20}) {
    PaddedImage image(16, 16, 0);
    for (int y = 0; y < 16; ++y) std::fill_n(image.row(y), 16, uint8_t{100});
    image.row(6)[3] = image.row(7)[3] = static_cast<uint8_t>(100 + levels);
    const ThresholdGrid grid = Map(image.view());
    EXPECT_EQ(grid.floor, std::vector<uint8_t>{0});
    EXPECT_EQ(grid.ceiling, std::vector<uint8_t>{static_cast<uint8_t>(levels == 19 ? 0 : 255)});
  }
}

TEST(ThresholdTest, PaperThresholdOfAFlatPicture) {
  const int table[][2] = {{0, 400}, {52, 400}, {53, 403}, {200, 1520}, {255, 1938}};
  for (const auto& [level, expected] : table) {
    PaddedImage image(70, 50, 0);
    for (int y = 0; y < 50; ++y) std::fill_n(image.row(y), 70, static_cast<uint8_t>(level));
    for (const uint16_t value : Map(image.view(), PaperParams()).value) EXPECT_EQ(value, expected);
  }
  // Both floors: without beta, dark parts are lifted to alpha, 45 x 0.95.
  ThresholdParams params = PaperParams();
  params.beta = 0;
  const PaddedImage black(70, 50, 0);
  for (const uint16_t value : Map(black.view(), params).value) EXPECT_EQ(value, 342);
}

// Noise of sigma 2, nearly normal: the sum of 12 uniform numbers has variance 1.
int Noisy(int level, Random* random) {
  int sum = 0;
  for (int i = 0; i < 12; ++i) sum += random->Below(2001) - 1000;
  return std::clamp(level + RoundDivide(sum, 1000), 0, 255);
}

BitImage Binary(const ImageView& image) {
  BitImage bits;
  scalar::Binarize(image, Map(image), &bits);
  return bits;
}

// A noisy wall with a square of ink in its middle; light(x) scales both.
template <typename Light>
void ExpectSquareAlone(int wall, int ink, int side, Light light) {
  PaddedImage image(640, 480, 0);
  Random random(static_cast<uint64_t>(side));
  const auto inside = [side](int x, int y) {
    return std::max(std::abs(2 * x - 639), std::abs(2 * y - 479)) < side;
  };
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const int level = static_cast<int>((inside(x, y) ? ink : wall) * light(x));
      image.row(y)[x] = static_cast<uint8_t>(Noisy(level, &random));
    }
  }
  const BitImage bits = Binary(image.view());
  int wrong = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) wrong += IsWhite(bits, x, y) == inside(x, y);
  }
  EXPECT_EQ(wrong, 0) << "ink " << ink << " on " << wall << ", side " << side;
}

TEST(ThresholdTest, FlatNoisyWallHasOneColour) {
  const auto even = [](int) { return 1.0; };
  for (const int wall : {5, 60, 128, 250}) ExpectSquareAlone(wall, wall, 0, even);
}

TEST(ThresholdTest, InkIsBlackAtAnySizeAndWallWhite) {
  const auto even = [](int) { return 1.0; };
  const auto falling = [](int x) { return 1 - x / 2000.0; };
  for (const int side : {6, 20, 60, 200, 400}) {
    ExpectSquareAlone(220, 20, side, even);
    ExpectSquareAlone(250, 100, side, even);  // bright ink, 40 % of white
    ExpectSquareAlone(80, 32, side, even);
    ExpectSquareAlone(240, 60, side, falling);
  }
}

TEST(ThresholdTest, NothingToSeeIsWhite) {
  for (const int level : {0, 1, 128, 255}) {
    PaddedImage image(100, 70, 0);
    for (int y = 0; y < 70; ++y) std::fill_n(image.row(y), 100, static_cast<uint8_t>(level));
    for (const uint16_t value : Map(image.view()).value) ASSERT_EQ(value, 0);
    const BitImage bits = Binary(image.view());
    for (int y = 0; y < 70; ++y) {
      for (int x = 0; x < 100; ++x) ASSERT_TRUE(IsWhite(bits, x, y));
    }
  }
}

}  // namespace
}  // namespace topotag
