#ifndef TOPOTAG_TESTS_RANDOM_IMAGE_H_
#define TOPOTAG_TESTS_RANDOM_IMAGE_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <ostream>
#include <random>
#include <vector>

#include "host/pipeline.h"
#include "topotag/image.h"

namespace topotag {

// The same numbers on every machine and with every standard library.
class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  int Below(int n) { return static_cast<int>(engine_() % static_cast<uint64_t>(n)); }
  int Between(int lo, int hi) { return lo + Below(hi - lo + 1); }
  bool Chance(int percent) { return Below(100) < percent; }

 private:
  std::mt19937_64 engine_;
};

// Fills the bytes between the rows of an image, whose pixels begin at `data`, with garbage.
inline void FillBetweenRows(const ImageView& image, uint8_t* data, uint64_t seed) {
  Random random(seed);
  for (int y = 0; y + 1 < image.height; ++y) {
    for (ptrdiff_t x = image.width; x < image.stride; ++x) {
      data[y * image.stride + x] = static_cast<uint8_t>(random.Below(256));
    }
  }
}

// An image that ends with the last row's last pixel: a read behind it is a read behind the
// allocation. The bytes between the rows can be filled with garbage.
class PaddedImage {
 public:
  PaddedImage(int width, int height, int padding)
      : width_(width),
        height_(height),
        stride_(width + padding),
        data_(new uint8_t[static_cast<size_t>(stride_) * static_cast<size_t>(height - 1) +
                          static_cast<size_t>(width)]()) {}

  uint8_t* row(int y) { return data_.get() + y * stride_; }
  ImageView view() const { return {data_.get(), width_, height_, stride_}; }

  void FillPadding(uint64_t seed) { FillBetweenRows(view(), data_.get(), seed); }

 private:
  int width_;
  int height_;
  ptrdiff_t stride_;
  std::unique_ptr<uint8_t[]> data_;
};

enum class Content { kNoise, kFlatNoise, kGradient, kCheckerboard, kBlobs, kBlack, kWhite };

struct ImageCase {
  int width;
  int height;
  int padding;
  Content content;
  uint64_t seed;
};

inline std::ostream& operator<<(std::ostream& out, const ImageCase& c) {
  return out << c.width << "x" << c.height << " + " << c.padding << ", content "
             << static_cast<int>(c.content) << ", seed " << c.seed;
}

// A two-level picture with large flat parts, each with a little noise.
inline void FillBlobs(PaddedImage* image, Random* random) {
  const ImageView view = image->view();
  const int ground = random->Below(256), ink = random->Below(256), noise = random->Between(1, 6);
  struct Blob {
    int x, y, radius;
    bool round;
  };
  std::vector<Blob> blobs(static_cast<size_t>(random->Between(1, 5)));
  for (Blob& blob : blobs) {
    blob = {random->Below(view.width), random->Below(view.height), random->Between(1, 24),
            random->Chance(50)};
  }
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const bool inside = std::any_of(blobs.begin(), blobs.end(), [&](const Blob& b) {
        const int dx = std::abs(x - b.x), dy = std::abs(y - b.y);
        return b.round ? dx * dx + dy * dy <= b.radius * b.radius : std::max(dx, dy) <= b.radius;
      });
      const int level = (inside ? ink : ground) + random->Below(noise);
      image->row(y)[x] = static_cast<uint8_t>(std::min(level, 255));
    }
  }
}

inline PaddedImage MakeImage(const ImageCase& c) {
  PaddedImage image(c.width, c.height, c.padding);
  image.FillPadding(c.seed + 1);
  Random random(c.seed);
  if (c.content == Content::kBlobs) {
    FillBlobs(&image, &random);
    return image;
  }
  const int base = random.Below(256), other = random.Below(256), cell = random.Between(1, 40);
  const int slope_x = random.Between(-40, 40), slope_y = random.Between(-40, 40);
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      int level = c.content == Content::kWhite ? 255 : 0;
      if (c.content == Content::kNoise) level = random.Below(256);
      if (c.content == Content::kFlatNoise) level = base + random.Below(cell);
      if (c.content == Content::kGradient) level = base + (slope_x * x + slope_y * y) / 16;
      if (c.content == Content::kCheckerboard) level = (x / cell + y / cell) % 2 ? base : other;
      image.row(y)[x] = static_cast<uint8_t>(std::clamp(level, 0, 255));
    }
  }
  return image;
}

// Every pair of sides around the multiples of tiles, blocks and words, and the longest rows and
// columns there can be, with every content.
inline std::vector<ImageCase> AllCases() {
  std::vector<ImageCase> cases;
  const int sides[] = {1, 2, 3, 5, 15, 16, 17, 31, 32, 33, 47, 63, 64, 65, 96, 127, 129, 161};
  uint64_t seed = 0;
  const auto add = [&](int width, int height) {
    for (const Content content :
         {Content::kNoise, Content::kFlatNoise, Content::kGradient, Content::kCheckerboard,
          Content::kBlobs, Content::kBlack, Content::kWhite}) {
      seed += 2;
      cases.push_back({width, height, static_cast<int>(seed % 7), content, seed});
    }
  };
  for (const int width : sides) {
    for (const int height : sides) add(width, height);
  }
  add(kMaxImageSide, 1);
  add(kMaxImageSide, 3);
  add(1, kMaxImageSide);
  return cases;
}

// Bounds of all kinds that tiles have: none, or one colour.
inline void RandomizeBounds(Random* random, ThresholdGrid* grid) {
  for (size_t i = 0; i < grid->floor.size(); ++i) {
    const int dice = random->Below(5);
    grid->floor[i] = dice == 0 ? 255 : 0;
    grid->ceiling[i] = dice == 1 ? 0 : 255;
  }
}

// White where white(x, y) says so.
template <typename White>
BitImage MakeBits(int width, int height, White white) {
  BitImage bits;
  bits.Resize(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      bits.row(y)[x / 64] |= uint64_t{white(x, y) ? 1U : 0U} << (x % 64);
    }
  }
  return bits;
}

inline bool IsWhite(const BitImage& bits, int x, int y) {
  return (bits.row(y)[x / 64] >> (x % 64) & 1) != 0;
}

}  // namespace topotag

#endif  // TOPOTAG_TESTS_RANDOM_IMAGE_H_
