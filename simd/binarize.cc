#include "simd/binarize.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "host/workers.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/binarize.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace topotag::simd {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Up to four 128-bit blocks: a block of bytes is one tile.
constexpr hn::CappedTag<uint8_t, 64> kU8;
constexpr hn::CappedTag<uint16_t, 32> kU16;
constexpr hn::CappedTag<int16_t, 32> kI16;
constexpr hn::Rebind<uint8_t, decltype(kI16)> kU8Half;

// Room for the corners of the widest image and the block that is read at each.
constexpr size_t kMaxCorners = kMaxImageSide / kTile + 2 + 256;

struct Lines {
  // Of one row of tiles.
  HWY_ALIGN uint16_t upper[kMaxCorners];
  HWY_ALIGN uint16_t lower[kMaxCorners];
  HWY_ALIGN uint8_t floor[kMaxCorners];
  HWY_ALIGN uint8_t ceiling[kMaxCorners];
  // Of the rows of pixels that share thresholds.
  HWY_ALIGN int16_t base[kMaxCorners];  // 32 times the threshold at the corner, plus 128 to round
  HWY_ALIGN int16_t step[kMaxCorners];  // to the next corner, per 32th of a tile
};

void LoadTiles(const ThresholdGrid& grid, int tile_row, Lines* lines) {
  std::copy_n(grid.row(tile_row), grid.cols, lines->upper);
  std::copy_n(grid.row(tile_row + 1), grid.cols, lines->lower);
  std::copy_n(grid.floor.data() + grid.tile(tile_row, 0), grid.cols - 1, lines->floor);
  std::copy_n(grid.ceiling.data() + grid.tile(tile_row, 0), grid.cols - 1, lines->ceiling);
}

// Interpolates the corners of the tiles vertically for the group of rows at y. All products fit 16
// bits modulo 2^16, and the final sums fit without. A tile of one colour does not step, and its
// base is its floor or its ceiling, 256 times.
void InterpolateCorners(int y, int cols, Lines* lines) {
  const int group = (y % kTile) / kRowsPerThreshold;
  const int weight = group * kRowsPerThreshold + kRowsPerThreshold / 2;
  const auto w_upper = hn::Set(kU16, static_cast<uint16_t>(kTile - weight));
  const auto w_lower = hn::Set(kU16, static_cast<uint16_t>(weight));
  for (size_t c = 0; c < static_cast<size_t>(cols); c += hn::Lanes(kU16)) {
    const auto upper = hn::Mul(hn::Load(kU16, lines->upper + c), w_upper);
    const auto lower = hn::Mul(hn::Load(kU16, lines->lower + c), w_lower);
    const auto sum = hn::Add(hn::Add(upper, lower), hn::Set(kU16, kTile / 2));
    hn::Store(hn::BitCast(kI16, hn::ShiftRight<4>(sum)), kI16, lines->step + c);
  }
  for (size_t c = 0; c < static_cast<size_t>(cols); c += hn::Lanes(kI16)) {
    const auto floor = hn::PromoteTo(kI16, hn::Load(kU8Half, lines->floor + c));
    const auto ceiling = hn::PromoteTo(kI16, hn::Load(kU8Half, lines->ceiling + c));
    const auto flat = hn::Eq(floor, ceiling);
    const auto value = hn::Load(kI16, lines->step + c);
    const auto next = hn::LoadU(kI16, lines->step + c + 1);
    const auto base = hn::Add(hn::ShiftLeft<5>(value), hn::Set(kI16, 128));
    hn::Store(hn::IfThenElse(flat, hn::ShiftLeft<8>(floor), base), kI16, lines->base + c);
    hn::Store(hn::IfThenZeroElse(flat, hn::Sub(next, value)), kI16, lines->step + c);
  }
}

// Interpolates horizontally, a vector of pixels at a time. The pixels of a tile are computed in
// pairs, the even one in the low, the odd one in the high byte of 16 bits.
class Interpolator {
 public:
  Interpolator() {
    // In block b: bytes 2b and 2b + 1, eight times.
    const auto block = hn::ShiftRight<3>(hn::Iota(kU16, 0));
    pick_ =
        hn::BitCast(kI16, hn::Add(hn::Mul(block, hn::Set(kU16, 0x0202)), hn::Set(kU16, 0x0100)));
    // 4 i + 1 for the i-th pair of a tile: weight of the right corner at its even pixel.
    const auto pair = hn::And(hn::Iota(kI16, 0), hn::Set(kI16, 7));
    weight_ = hn::Add(hn::ShiftLeft<2>(pair), hn::Set(kI16, 1));
  }

  // Thresholds of the pixels from x on, a multiple of the vector's length.
  hn::Vec<decltype(kU8)> At(const Lines& lines, size_t x) const {
    const size_t corner = x / kTile;
    const auto base = hn::TableLookupBytes(hn::LoadDup128(kI16, lines.base + corner), pick_);
    const auto step = hn::TableLookupBytes(hn::LoadDup128(kI16, lines.step + corner), pick_);
    const auto even = hn::Add(base, hn::Mul(step, weight_));
    const auto odd = hn::Add(even, hn::Add(step, step));
    const auto low = hn::ShiftRight<8>(hn::BitCast(kU16, even));
    const auto high = hn::And(hn::BitCast(kU16, odd), hn::Set(kU16, 0xff00));
    return hn::BitCast(kU8, hn::Or(low, high));
  }

 private:
  hn::Vec<decltype(kI16)> pick_;
  hn::Vec<decltype(kI16)> weight_;
};

template <class V>
auto NotBelow(V pixels, V threshold) {
  return hn::Eq(hn::Max(pixels, threshold), pixels);
}

// Bits of the last, incomplete vector of a row, and zeros up to the row's last word.
void BinarizeTail(const uint8_t* row, hn::Vec<decltype(kU8)> threshold, size_t begin, size_t end,
                  size_t row_bytes, uint8_t* bytes) {
  HWY_ALIGN uint8_t pixels[HWY_MAX_BYTES] = {};
  std::copy(row + begin, row + end, pixels);
  uint64_t white = 0;
  hn::StoreMaskBits(kU8, NotBelow(hn::Load(kU8, pixels), threshold),
                    reinterpret_cast<uint8_t*>(&white));
  white &= (uint64_t{1} << (end - begin)) - 1;
  std::memcpy(bytes + begin / 8, &white, row_bytes - begin / 8);
}

// The rows from y on that share thresholds.
template <int kRows>
void BinarizeGroup(const ImageView& image, const Interpolator& interpolator, const Lines& lines,
                   int y, BitImage* bits) {
  const uint8_t* row[kRows];
  uint8_t* bytes[kRows];
  for (int r = 0; r < kRows; ++r) {
    row[r] = image.row(y + r);
    bytes[r] = reinterpret_cast<uint8_t*>(bits->row(y + r));
  }
  const auto width = static_cast<size_t>(image.width);
  const auto row_bytes = static_cast<size_t>(bits->words) * 8;
  size_t x = 0;
  for (; x + hn::Lanes(kU8) <= width; x += hn::Lanes(kU8)) {
    const auto threshold = interpolator.At(lines, x);
    for (int r = 0; r < kRows; ++r) {
      hn::StoreMaskBits(kU8, NotBelow(hn::LoadU(kU8, row[r] + x), threshold), bytes[r] + x / 8);
    }
  }
  for (int r = 0; r < kRows; ++r) {
    if (x < width) {
      BinarizeTail(row[r], interpolator.At(lines, x), x, width, row_bytes, bytes[r]);
    } else {
      std::fill(bytes[r] + x / 8, bytes[r] + row_bytes, uint8_t{0});
    }
  }
}

}  // namespace

void BinarizeRows(const ImageView& image, const ThresholdGrid& grid, int begin, int end,
                  BitImage* bits) {
  const Interpolator interpolator;
  Lines lines;
  for (int y = begin; y < end; y += kRowsPerThreshold) {
    if (y % kTile == 0) LoadTiles(grid, y / kTile, &lines);
    InterpolateCorners(y, grid.cols, &lines);
    if (y + kRowsPerThreshold <= end) {
      BinarizeGroup<kRowsPerThreshold>(image, interpolator, lines, y, bits);
      continue;
    }
    for (int rest = y; rest < end; ++rest) {
      BinarizeGroup<1>(image, interpolator, lines, rest, bits);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace topotag::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag::simd {
namespace {

HWY_EXPORT(BinarizeRows);

constexpr int kRowsPerTask = 32;  // a multiple of kTile

}  // namespace

void Binarize(const ImageView& image, const ThresholdGrid& grid, Workers* workers, BitImage* bits) {
  bits->Resize(image.width, image.height);
  // The threshold map has just read the image in the other direction.
  workers->ForBackward((image.height + kRowsPerTask - 1) / kRowsPerTask, [&](int task) {
    const int begin = task * kRowsPerTask;
    const int end = std::min(begin + kRowsPerTask, image.height);
    HWY_DYNAMIC_DISPATCH(BinarizeRows)(image, grid, begin, end, bits);
  });
}

}  // namespace topotag::simd
#endif  // HWY_ONCE
