#ifndef TOPOTAG_TESTS_WORST_PICTURE_H_
#define TOPOTAG_TESTS_WORST_PICTURE_H_

#include <algorithm>
#include <array>
#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/random_image.h"
#include "topotag/error.h"
#include "topotag/options.h"

namespace topotag {

/// A picture that is made from a few whole numbers, so that a search can change them: two textures
/// side by side in a mosaic, or one in the other's black, with noise and blur. Of any size; the
/// same pixels on every machine.
class WorstPicture {
 public:
  /// Of each texture: kind, periods, widths, slant, size and gap of markers, what their IDs and
  /// noise begin with.
  enum Gene { kKind, kPeriodX, kPeriodY, kWidthX, kWidthY, kSlant, kUnit, kSeed, kTextureGenes };
  enum Kind { kDots, kHoles, kStripes, kRings, kCells, kMarkers, kSpoiled, kDoubts, kTiny, kKinds };
  static constexpr int kSecond = kTextureGenes;  ///< the second texture's first gene
  /// Mix: 0 the first texture only, 1 a mosaic, 2 the second one where the first is black.
  enum { kMix = 2 * kTextureGenes, kMosaic, kDark, kBright, kNoise, kBlur, kGenes };
  struct Range {
    int least, most;
  };

  static Range RangeOf(int gene) {
    static constexpr Range kTexture[] = {{0, kKinds - 1}, {1, 64}, {1, 64}, {1, 32},
                                         {1, 32},         {-3, 3}, {3, 48}, {0, 63}};
    static constexpr Range kWhole[] = {{0, 2}, {8, 320}, {0, 120}, {130, 255}, {0, 60}, {0, 3}};
    return gene < kMix ? kTexture[gene % kTextureGenes] : kWhole[gene - kMix];
  }

  static WorstPicture Made(Random* random) {
    WorstPicture picture;
    for (int gene = 0; gene < kGenes; ++gene) picture.Change(gene, random);
    return picture;
  }
  /// @throws Error (kParse) unless it is what Text gives.
  static WorstPicture Parse(const std::string& text) {
    WorstPicture picture;
    std::istringstream stream(text);
    for (int gene = 0; gene < kGenes; ++gene) {
      int& value = picture.genes_[static_cast<size_t>(gene)];
      const Range range = RangeOf(gene);
      if (!(stream >> value) || value < range.least || value > range.most) {
        throw Error(ErrorCode::kParse, "'" + text + "': number " + std::to_string(gene + 1) +
                                           " is missing or not in its range");
      }
    }
    return picture;
  }
  std::string Text() const {
    std::string text;
    for (const int value : genes_) text += (text.empty() ? "" : " ") + std::to_string(value);
    return text;
  }

  /// Anew, or by a little.
  void Change(int gene, Random* random) {
    const Range range = RangeOf(gene);
    int& value = genes_[static_cast<size_t>(gene)];
    value = random->Chance(50)
                ? random->Between(range.least, range.most)
                : std::clamp(value + random->Between(-2, 2), range.least, range.most);
  }
  /// Each gene of one or the other.
  static WorstPicture Mixed(const WorstPicture& a, const WorstPicture& b, Random* random) {
    WorstPicture mixed = a;
    for (size_t i = 0; i < kGenes; ++i) {
      if (random->Chance(50)) mixed.genes_[i] = b.genes_[i];
    }
    return mixed;
  }

  PaddedImage Draw(int width, int height) const {
    PaddedImage image(width, height, 0);
    uint32_t state = 1;
    const int noise = gene(kNoise), range = gene(kBright) - gene(kDark);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        int level = gene(kDark) + range * White(x, y) / (kSamples * kSamples);
        state = state * 1664525u + 1013904223u;
        if (noise > 0) {
          level += static_cast<int>((state >> 8) % static_cast<uint32_t>(2 * noise + 1)) - noise;
        }
        image.row(y)[x] = static_cast<uint8_t>(std::clamp(level, 0, 255));
      }
    }
    for (int i = 0; i < gene(kBlur); ++i) Blur(&image);
    return image;
  }

 private:
  static constexpr int kSamples = 4;  // of a pixel, along each axis

  int gene(int i) const { return genes_[static_cast<size_t>(i)]; }

  static uint32_t Hash(int x, int y, int seed) {
    uint32_t h = static_cast<uint32_t>(x) * 0x9e3779b1u ^ static_cast<uint32_t>(y) * 0x85ebca77u ^
                 static_cast<uint32_t>(seed) * 0xc2b2ae3du;
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    return h ^ h >> 13;
  }

  // How much of a pixel is white, in samples: of markers with small units, whose edges are within
  // pixels, and which nothing could read otherwise.
  int White(int x, int y) const {
    if (!IsFine(0) && !IsFine(kSecond)) {
      return IsWhite(x, y, kSamples * x, kSamples * y) ? kSamples * kSamples : 0;
    }
    int white = 0;
    for (int i = 0; i < kSamples * kSamples; ++i) {
      white += IsWhite(x, y, kSamples * x + i % kSamples, kSamples * y + i / kSamples);
    }
    return white;
  }
  bool IsFine(int first) const {
    const int kind = gene(first + kKind);
    const int unit = gene(first + kUnit);
    return (kind == kMarkers || kind == kSpoiled) && unit < 24 && unit % 8 != 0;
  }

  bool IsWhite(int x, int y, int sx, int sy) const {
    const int mosaic = gene(kMosaic);
    switch (gene(kMix)) {
      case 1:
        return IsWhite((x / mosaic + y / mosaic) % 2 * kSecond, x, y, sx, sy);
      case 2:
        return IsWhite(0, x, y, sx, sy) || IsWhite(kSecond, x, y, sx, sy);
      default:
        return IsWhite(0, x, y, sx, sy);
    }
  }

  bool IsWhite(int first, int x, int y, int sx, int sy) const {
    const auto of = [&](int i) { return gene(first + i); };
    const int px = of(kPeriodX), py = of(kPeriodY), wx = of(kWidthX), wy = of(kWidthY);
    const int u = (x + of(kSlant) * (y / py) + 1024) % px, v = y % py;
    switch (of(kKind)) {
      case kDots:
        return u < wx && v < wy;
      case kHoles:
        return u >= wx || v >= wy;
      case kStripes:
        return (x + of(kSlant) * y + (1 << 20)) % px < wx;
      case kRings:
        return std::min({u, v, px - 1 - u, py - 1 - v}) / (1 + wx / 4) % 2 != 0;
      case kCells:
        return Hash(x / (1 + px / 16), y / (1 + py / 16), of(kSeed)) % 32 <
               static_cast<uint32_t>(wx);
      case kDoubts:
        return u != 0 && v != 0 && !(u % (1 + wx) >= (1 + wx) / 2 && v % (1 + wy) >= (1 + wy) / 2);
      case kTiny:
        return IsTiny(x / (1 + px / 16), y / (1 + py / 16));
      default:
        return IsMarker(first, sx, sy);
    }
  }

  // White areas with just what a candidate of 3 x 3 has, as small as can be.
  static bool IsTiny(int x, int y) {
    static constexpr const char* kCell[] = {
        "............", ".###########", ".#.....#####", ".#.#.#.#.#.#", ".#.....#####",
        ".#######.#.#", ".###########", ".#.#.#.#####", ".###########", ".###########",
    };
    return kCell[y % 10][x % 12] == '#';
  }

  // Upright markers side by side, kUnit eighths of a pixel a unit, kWidthX units apart; spoiled
  // ones lack the gap behind the baseline node, or have a node where none should be.
  bool IsMarker(int first, int sx, int sy) const {
    const auto of = [&](int i) { return gene(first + i); };
    const int n = 3 + of(kPeriodX) % 6, side = 4 * n + 1, step = side + 1 + of(kWidthX) % 6;
    const int x = 8 / kSamples * sx / of(kUnit), y = 8 / kSamples * sy / of(kUnit);
    const int u = x % step, v = y % step;
    if (u >= side || v >= side) return false;
    const uint32_t id = Hash(x / step, y / step, of(kSeed));
    const int column = (u - 1) / 4, row = (v - 1) / 4;
    const int a = (u + 3) % 4, b = (v + 3) % 4;  // within a cell of 3 units and a gap
    const bool is_baseline = row == 0 && column < 2;
    if (of(kKind) == kSpoiled && row == n - 1 && column == n - 1 && u > 0 && v > 0) return b == 3;
    if (is_baseline && u > 0 && v > 0 && u < 6) return b == 3 || (b == 1 && (u == 2 || u == 4));
    if (u == 0 || v == 0 || a == 3 || b == 3 || is_baseline) return true;
    return a == 1 && b == 1 && (id >> (row * n + column) % 32 & 1) != 0;
  }

  static void Blur(PaddedImage* image) {
    const ImageView view = image->view();
    for (int y = 0; y + 1 < view.height; ++y) {
      uint8_t* row = image->row(y);
      const uint8_t* below = image->row(y + 1);
      for (int x = 0; x + 1 < view.width; ++x) {
        row[x] = static_cast<uint8_t>((row[x] + row[x + 1] + below[x] + below[x + 1] + 2) / 4);
      }
    }
  }

  std::array<int, kGenes> genes_{};
};

/// Sets of options that change what is done with a frame; `all` does not smooth it, which leaves
/// less to be found.
inline const std::vector<std::string>& WorstOptionNames() {
  static const std::vector<std::string> kNames{"default", "far",      "inverted",    "pre_blur",
                                               "hidden",  "families", "photometric", "all"};
  return kNames;
}

/// Of one thread, with the backend simd, for frames of a size. @throws Error for an unknown name.
inline Options WorstOptions(const std::string& name, int width, int height) {
  const auto& names = WorstOptionNames();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    throw Error(ErrorCode::kInvalidArgument, "no options are called '" + name + "'");
  }
  const auto is = [&name](const char* one) { return name == one || name == "all"; };
  Options options;
  options.backend = BackendKind::kSimd;
  options.threads = 1;
  options.far = is("far");
  options.inverted = is("inverted");
  options.pre_blur = name == "pre_blur";
  if (is("hidden")) options.hidden_nodes = 5;
  if (is("families")) {
    for (int n = 6; n <= Family::kMaxN; ++n) options.families.push_back(Family(n));
  }
  if (is("photometric")) {
    options.camera.emplace();
    options.camera->width = width;
    options.camera->height = height;
    options.camera->fx = options.camera->fy = width;
    options.camera->cx = (width - 1) / 2.0;
    options.camera->cy = (height - 1) / 2.0;
    options.tag_size = 0.05;
    options.pose = PoseMode::kPhotometric;
  }
  return options;
}

inline constexpr char kManyMarkers[] = "5 6 1 6 1 0 16 3 5 6 1 6 1 0 16 3 0 8 30 220 0 0";
inline constexpr char kManyFarMarkers[] = "5 6 1 6 1 0 10 3 5 6 1 6 1 0 16 3 0 8 30 220 0 1";

/// A picture that is bad for a set of options.
struct KnownWorst {
  std::string options;
  std::string picture;
};

/// What bench/worst_case --search has found, and two that were made by hand: frames full of
/// markers, as small as they can be read with and without Options::far.
inline const std::vector<KnownWorst>& KnownWorstPictures() {
  static const std::vector<KnownWorst> kKnown{
      {"default", "7 12 1 5 31 1 29 16 5 3 1 30 20 1 10 58 2 8 47 168 31 0"},
      {"default", "6 10 9 30 23 -1 16 1 8 1 1 25 19 3 9 2 0 8 70 148 1 2"},
      {"default", kManyMarkers},
      {"far", "5 33 13 1 1 3 16 15 4 1 41 1 32 0 3 1 2 46 120 186 0 2"},
      {"far", "1 4 3 15 9 2 24 60 6 18 62 1 18 2 21 2 2 283 101 201 31 2"},
      {"far", kManyFarMarkers},
      {"inverted", "2 27 28 2 31 0 5 6 5 2 9 1 17 -1 36 11 2 135 2 235 9 0"},
      {"pre_blur", "5 64 1 24 1 -1 30 26 6 1 28 6 1 1 3 0 1 257 0 130 1 2"},
      {"hidden", "3 17 1 2 23 1 28 2 5 2 2 30 1 -2 10 37 2 241 51 247 17 0"},
      {"families", "5 29 39 2 30 -1 20 13 6 60 24 10 21 0 8 19 0 10 118 200 53 0"},
      {"photometric", kManyMarkers},
      {"all", kManyMarkers},
      {"all", kManyFarMarkers}};
  return kKnown;
}

}  // namespace topotag

#endif  // TOPOTAG_TESTS_WORST_PICTURE_H_
