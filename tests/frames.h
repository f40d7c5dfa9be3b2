#ifndef TOPOTAG_TESTS_FRAMES_H_
#define TOPOTAG_TESTS_FRAMES_H_

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <ostream>
#include <vector>

#include "tests/guarded.h"
#include "tests/marker_canvas.h"
#include "tests/random_image.h"

namespace topotag {

/// What a frame shows. From kCheckerboard on two grey levels, with a little noise or blur.
enum class FrameKind {
  kNoise,
  kBlurredNoise,
  kConstant,
  kGradient,
  kCheckerboard,
  kStripes,
  kComb,
  kSpiral,
  kRings,
  kRectangles,
  kMarkers,
  kBinaryNoise,
  kCoarseNoise,
};
inline constexpr int kFrameKinds = static_cast<int>(FrameKind::kCoarseNoise) + 1;

inline const char* Name(FrameKind kind) {
  static constexpr const char* kNames[kFrameKinds] = {
      "noise",  "blurred noise", "constant",   "gradient", "checkerboard", "stripes",     "comb",
      "spiral", "rings",         "rectangles", "markers",  "binary noise", "coarse noise"};
  return kNames[static_cast<int>(kind)];
}

struct FrameCase {
  int width;
  int height;
  int padding;
  FrameKind kind;
  uint64_t seed;
};

inline std::ostream& operator<<(std::ostream& out, const FrameCase& c) {
  return out << c.width << "x" << c.height << " + " << c.padding << ", " << Name(c.kind)
             << ", seed " << c.seed;
}

/// Everything follows from the seed; consecutive seeds go through all kinds. Most sides are below
/// 200 pixels, many around the multiples of tiles, words and vectors.
inline FrameCase RandomFrameCase(uint64_t seed) {
  Random random(seed);
  const auto side = [&random] {
    const int dice = random.Below(100);
    if (dice < 5) return 1;
    if (dice < 35) return std::max(16 * random.Between(1, 13) + random.Between(-1, 1), 1);
    if (dice < 45) return 64 * random.Between(1, 4) + random.Between(-1, 1);
    if (dice < 46) return random.Between(200, 700);
    return random.Between(1, 200);
  };
  const int width = side(), height = side();
  const int padding = random.Chance(50) ? 0 : random.Between(1, 70);
  return {width, height, padding, static_cast<FrameKind>(seed % kFrameKinds), seed};
}

namespace frame_internal {

using Rule = std::function<bool(int x, int y)>;

// A marker's bits where they fit, at random places and sizes.
inline Rule Markers(int width, int height, Random* random) {
  Canvas canvas(width, height);
  for (int i = 0; i < 8; ++i) {
    DrawnMarker marker{random->Between(3, 5), 0,
                       random->Between(1, 1 + std::min(width, height) / 24)};
    if (marker.side() + 2 > std::min(width, height)) continue;
    marker.id = static_cast<uint64_t>(random->Below(1 << (marker.n * marker.n - 2)));
    marker.x = random->Between(1, width - marker.side() - 1);
    marker.y = random->Between(1, height - marker.side() - 1);
    canvas.Fill(marker.x - 1, marker.y - 1, marker.side() + 2, marker.side() + 2, false);
    Draw(marker, &canvas);
  }
  return [bits = canvas.Bits()](int x, int y) { return IsWhite(bits, x, y); };
}

// Rectangles over one another, each inverting what it covers.
inline Rule Rectangles(int width, int height, Random* random) {
  struct Box {
    int left, top, right, bottom;
  };
  std::vector<Box> boxes(static_cast<size_t>(random->Between(1, 30)));
  for (Box& b : boxes) {
    b.left = random->Between(-5, width);
    b.top = random->Between(-5, height);
    b.right = b.left + random->Between(1, 1 + width / 2);
    b.bottom = b.top + random->Between(1, 1 + height / 2);
  }
  return [boxes](int x, int y) {
    return std::count_if(boxes.begin(), boxes.end(),
                         [=](const Box& b) {
                           return x >= b.left && x < b.right && y >= b.top && y < b.bottom;
                         }) %
               2 !=
           0;
  };
}

// Cells of `size` pixels, white with a chance of `density` per cent.
inline Rule Cells(int width, int height, int size, int density, Random* random) {
  const int columns = (width + size - 1) / size, rows = (height + size - 1) / size;
  std::vector<bool> cells(static_cast<size_t>(columns) * static_cast<size_t>(rows));
  for (size_t i = 0; i < cells.size(); ++i) cells[i] = random->Chance(density);
  return [=](int x, int y) { return cells[static_cast<size_t>(y / size * columns + x / size)]; };
}

inline Rule MakeRule(const FrameCase& c, Random* random) {
  const int w = c.width, h = c.height;
  const int size = random->Chance(50) ? random->Between(1, 4) : random->Between(1, 40);
  const int shift = random->Below(size + 1), turn = random->Below(4);
  switch (c.kind) {
    case FrameKind::kCheckerboard:
      return [=](int x, int y) { return ((x + shift) / size + (y + shift) / size) % 2 != 0; };
    case FrameKind::kStripes:  // across, down, and both diagonals
      return [=](int x, int y) {
        const int along = turn == 0 ? x : turn == 1 ? y : turn == 2 ? x + y : x - y + h;
        return (along + shift) / size % 2 != 0;
      };
    case FrameKind::kComb:
      return [=](int x, int y) {
        if (turn == 0) return x / size % 2 == 0 || y < size;
        if (turn == 1) return x / size % 2 == 0 || h - 1 - y < size;
        if (turn == 2) return y / size % 2 == 0 || x < size;
        // A meander: open left and right by turns.
        return y / size % 2 == 0 || (y / size % 4 == 1 ? x < size : w - 1 - x < size);
      };
    case FrameKind::kSpiral:  // rings, each opened at its upper left and led into the next
      return [=](int px, int py) {
        const int x = px / size, y = py / size;
        const int depth = std::min({x, y, (w - 1) / size - x, (h - 1) / size - y});
        const bool gate = x == depth && y == depth + 1;
        return (depth % 2 == 0) != gate;
      };
    case FrameKind::kRings:
      return [=](int x, int y) {
        const int depth = turn == 0 ? std::abs(x - w / 2) + std::abs(y - h / 2)
                                    : std::min({x, y, w - 1 - x, h - 1 - y});
        return (depth + shift) / size % 2 != 0;
      };
    case FrameKind::kRectangles:
      return Rectangles(w, h, random);
    case FrameKind::kMarkers:
      return Markers(w, h, random);
    case FrameKind::kBinaryNoise:
      return Cells(w, h, 1, random->Between(1, 50), random);
    default:
      return Cells(w, h, random->Between(2, 5), random->Between(1, 99), random);
  }
}

// Means over (2 radius + 1) pixels along each row, then along each column.
inline void Blur(int radius, GuardedImage* image) {
  const int w = image->width(), h = image->height();
  std::vector<int> line(static_cast<size_t>(std::max(w, h)));
  const auto blur_line = [&](int length, const auto& at) {
    for (int i = 0; i < length; ++i) line[static_cast<size_t>(i)] = at(i);
    for (int i = 0; i < length; ++i) {
      int sum = 0;
      for (int k = i - radius; k <= i + radius; ++k) {
        sum += line[static_cast<size_t>(std::clamp(k, 0, length - 1))];
      }
      at(i) = static_cast<uint8_t>(sum / (2 * radius + 1));
    }
  };
  for (int y = 0; y < h; ++y) {
    blur_line(w, [&](int x) -> uint8_t& { return image->row(y)[x]; });
  }
  for (int x = 0; x < w; ++x) {
    blur_line(h, [&](int y) -> uint8_t& { return image->row(y)[x]; });
  }
}

}  // namespace frame_internal

inline GuardedImage MakeFrame(const FrameCase& c, Guard guard = Guard::kEnd) {
  Random random(c.seed ^ 0x9e3779b97f4a7c15);
  GuardedImage image(c.width, c.height, c.padding, guard);
  image.FillPadding(c.seed + 1);
  const int base = random.Below(256);
  // Also below the contrast that a tile needs to decide by itself.
  const int other = random.Chance(30) ? base + random.Between(-25, 25) : random.Below(256);
  const int noise = random.Chance(40) ? random.Between(2, 12) : 1;
  const int slope_x = random.Between(-40, 40), slope_y = random.Between(-40, 40);
  const bool is_two_level = c.kind >= FrameKind::kCheckerboard;
  const auto white = is_two_level ? frame_internal::MakeRule(c, &random) : nullptr;
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      int level = base;
      if (is_two_level) level = white(x, y) ? base : other;
      if (c.kind == FrameKind::kGradient) level += (slope_x * x + slope_y * y) / 16;
      if (c.kind == FrameKind::kNoise || c.kind == FrameKind::kBlurredNoise) {
        level = random.Below(256);
      }
      if (noise > 1) level += random.Below(noise);
      image.row(y)[x] = static_cast<uint8_t>(std::clamp(level, 0, 255));
    }
  }
  if (c.kind == FrameKind::kBlurredNoise || random.Chance(20)) {
    const int radius = random.Between(1, 3);
    for (int pass = 0; pass < 2; ++pass) frame_internal::Blur(radius, &image);
  }
  return image;
}

/// The same as bits, without noise or blur; kinds of many grey levels give coarse noise.
inline BitImage MakeFrameBits(const FrameCase& c) {
  Random random(c.seed);
  return MakeBits(c.width, c.height, frame_internal::MakeRule(c, &random));
}

}  // namespace topotag

#endif  // TOPOTAG_TESTS_FRAMES_H_
