#include "host/centroid.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "host/centroid.cc"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace topotag {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kMaxLanes = 32;
// Iota of Highway 1.0 is a loop over the lanes.
HWY_ALIGN constexpr int16_t kColumns[kMaxLanes] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10,
                                                   11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21,
                                                   22, 23, 24, 25, 26, 27, 28, 29, 30, 31};
// Rows of one tile, whose sums are held in 32 bits.
constexpr int kMaxRows = 64;
// Rows whose sums are held in 16 bits: the weights 0 to 3 of a block's rows add up to 6.
constexpr int kBlockRows = 4;
constexpr int kShift = 8;  // of LinearValue

using D16 = hn::CappedTag<int16_t, kMaxLanes>;
using DU16 = hn::RebindToUnsigned<D16>;
using D32 = hn::RepartitionToWide<D16>;
using D8 = hn::Rebind<uint8_t, D16>;
using V16 = hn::Vec<D16>;

// Pixels that are summed together: as many columns as there are lanes, from x on, and rows y,
// y + step ..; in the patch.
struct Tile {
  int x, y;
  int rows, step;
};

// The part of a linear value that depends on the column: of dx its multiple of 2^8 and the rest
// apart, which 16 bits hold.
HWY_INLINE V16 Along(const LinearValue& value, V16 columns) {
  const D16 d;
  const V16 rest = hn::Set(d, static_cast<int16_t>((value.dx & 0xff) << 7));
  return hn::Add(hn::Mul(columns, hn::Set(d, static_cast<int16_t>(value.dx >> kShift))),
                 hn::MulFixedPoint15(columns, rest));
}

// The parts of a linear value that depend on the row, each twice in 32 bits: these are quicker to
// spread over a vector than 16.
struct RowTerms {
  HWY_ALIGN int32_t at[kMaxRows];
};

HWY_INLINE void FindRowTerms(const LinearValue& value, const Tile& tile, RowTerms* terms) {
  const D32 d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto low = hn::Set(d, 0xffff);
  const auto lane = hn::PromoteTo(d, hn::Load(hn::Rebind<int16_t, D32>(), kColumns));
  auto at = hn::Add(hn::Set(d, value.base + tile.y * value.dy),
                    hn::Mul(lane, hn::Set(d, tile.step * value.dy)));
  const auto next = hn::Set(d, lanes * tile.step * value.dy);
  for (int r = 0; r < tile.rows; r += lanes) {
    const auto term = hn::And(hn::ShiftRight<kShift>(at), low);
    hn::Store(hn::Or(term, hn::ShiftLeft<16>(term)), d, terms->at + r);
    at = hn::Add(at, next);
  }
}

HWY_INLINE V16 AtRow(const RowTerms& terms, int r) {
  return hn::BitCast(D16(), hn::Set(D32(), terms.at[r]));
}

// Between 0 and `one`.
HWY_INLINE V16 Inside(V16 distance, V16 reach, V16 one) {
  const DU16 du;
  const auto inside = hn::SaturatedSub(hn::BitCast(du, reach), hn::BitCast(du, hn::Abs(distance)));
  return hn::Min(hn::BitCast(D16(), inside), one);
}

HWY_INLINE int64_t Total(hn::Vec<D32> sums) { return hn::GetLane(hn::SumOfLanes(D32(), sums)); }

// `pixels` is the tile's first one, `next` bytes before that of its next row.
void SumTile(const DarknessPatch& patch, const Tile& tile, const uint8_t* pixels, ptrdiff_t next,
             DarknessSums* sums) {
  const D16 d;
  const D32 d32;
  RowTerms row_u, row_v, row_white;
  FindRowTerms(patch.u, tile, &row_u);
  FindRowTerms(patch.v, tile, &row_v);
  FindRowTerms(patch.inverse_white, tile, &row_white);
  const V16 lane = hn::Load(d, kColumns);
  const V16 columns = hn::Add(lane, hn::Set(d, static_cast<int16_t>(tile.x)));
  const V16 u_x = Along(patch.u, columns);
  const V16 v_x = Along(patch.v, columns);
  const V16 white_x = Along(patch.inverse_white, columns);
  const V16 reach_u = hn::Set(d, patch.reach_u);
  const V16 reach_v = hn::Set(d, patch.reach_v);
  const V16 one = hn::Set(d, patch.one);
  const V16 black = hn::Set(d, patch.black);
  const V16 ones = hn::Set(d, 1);
  const auto darkness = [&](int r) HWY_ATTR {
    const V16 grey = hn::ShiftLeft<7>(hn::PromoteTo(d, hn::LoadU(D8(), pixels + r * next)));
    const V16 relative = hn::MulFixedPoint15(grey, hn::Add(AtRow(row_white, r), white_x));
    const V16 weight = hn::Mul(Inside(hn::Add(AtRow(row_u, r), u_x), reach_u, one),
                               Inside(hn::Add(AtRow(row_v, r), v_x), reach_v, one));
    return hn::MulFixedPoint15(weight, hn::Sub(black, relative));
  };
  auto sum = hn::Zero(d32), sum_high = hn::Zero(d32);
  auto sum_x = hn::Zero(d32), sum_x_high = hn::Zero(d32);
  auto in_block = hn::Zero(d32), in_block_high = hn::Zero(d32);  // times the row in its block
  auto running = hn::Zero(d32);                                  // block b enters blocks - b times
  int blocks = 0;
  for (int r = 0; r < tile.rows; r += kBlockRows, ++blocks) {
    const int rest = tile.rows - r;
    const V16 s3 = rest > 3 ? darkness(r + 3) : hn::Zero(d);
    const V16 s23 = rest > 2 ? hn::Add(s3, darkness(r + 2)) : s3;
    const V16 s123 = rest > 1 ? hn::Add(s23, darkness(r + 1)) : s23;
    const V16 s = hn::Add(s123, darkness(r));
    const V16 below = hn::Add(hn::Add(s3, s23), s123);
    sum = hn::ReorderWidenMulAccumulate(d32, s, ones, sum, sum_high);
    sum_x = hn::ReorderWidenMulAccumulate(d32, s, lane, sum_x, sum_x_high);
    in_block = hn::ReorderWidenMulAccumulate(d32, below, ones, in_block, in_block_high);
    running = hn::Add(running, hn::Add(sum, sum_high));
  }
  const int64_t total = Total(hn::Add(sum, sum_high));
  const int64_t row =
      Total(hn::Add(in_block, in_block_high)) + kBlockRows * (blocks * total - Total(running));
  sums->sum += tile.step * total;
  sums->x += tile.step * (Total(hn::Add(sum_x, sum_x_high)) + tile.x * total);
  sums->y += tile.step * (tile.step * row + tile.y * total);
}

// Where the image is too narrow for a tile, its pixels are copied to a wider one; what is beyond
// the patch has no weight.
void SumNarrowTile(const DarknessPatch& patch, const Tile& tile, const uint8_t* pixels,
                   ptrdiff_t stride, DarknessSums* sums) {
  HWY_ALIGN uint8_t copy[kMaxRows * kMaxLanes] = {};
  const auto width =
      static_cast<size_t>(std::min(static_cast<int>(hn::Lanes(D16())), patch.width - tile.x));
  for (int r = 0; r < tile.rows; ++r) {
    std::memcpy(copy + r * kMaxLanes, pixels + r * tile.step * stride, width);
  }
  SumTile(patch, tile, copy, kMaxLanes, sums);
}

// All pixels: whole tiles that cover the patch, moved left where they would leave the image.
void SumAll(const ImageView& image, const DarknessPatch& patch, DarknessSums* sums) {
  const int lanes = static_cast<int>(hn::Lanes(D16()));
  const int tiles = (patch.width + lanes - 1) / lanes;
  const int first = std::min(0, image.width - patch.x - tiles * lanes);
  for (Tile tile{0, 0, 0, 1}; tile.y < patch.height; tile.y += kMaxRows) {
    tile.rows = std::min(kMaxRows, patch.height - tile.y);
    const uint8_t* row = image.row(patch.y + tile.y) + patch.x;
    if (patch.x + first < 0) {
      for (tile.x = 0; tile.x < patch.width; tile.x += lanes) {
        SumNarrowTile(patch, tile, row + tile.x, image.stride, sums);
      }
      continue;
    }
    tile.x = first;
    for (int i = 0; i < tiles; ++i, tile.x += lanes) {
      SumTile(patch, tile, row + tile.x, image.stride, sums);
    }
  }
}

// The rows of each group of columns that count.
void SumSome(const ImageView& image, const DarknessPatch& patch, DarknessSums* sums) {
  const int lanes = static_cast<int>(hn::Lanes(D16()));
  Tile tile{0, 0, 0, patch.step};
  for (; tile.x < patch.width; tile.x += lanes) {
    const bool wide = patch.x + tile.x + lanes <= image.width;
    tile.y = ReversedBits(tile.x / kGroupColumns, patch.step);
    for (; tile.y < patch.height; tile.y += tile.rows * tile.step) {
      tile.rows = std::min(kMaxRows, (patch.height - 1 - tile.y) / tile.step + 1);
      const uint8_t* pixels = image.row(patch.y + tile.y) + patch.x + tile.x;
      if (wide) {
        SumTile(patch, tile, pixels, image.stride * tile.step, sums);
      } else {
        SumNarrowTile(patch, tile, pixels, image.stride, sums);
      }
    }
  }
}

void SumDarkness(const ImageView& image, const DarknessPatch* patches, int count,
                 DarknessSums* sums) {
  for (int i = 0; i < count; ++i) {
    sums[i] = {};
    if (patches[i].width <= 0) continue;
    if (patches[i].step == 1) {
      SumAll(image, patches[i], &sums[i]);
    } else {
      SumSome(image, patches[i], &sums[i]);
    }
  }
}

const char* CentroidTargetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace topotag
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag {

HWY_EXPORT(SumDarkness);
HWY_EXPORT(CentroidTargetName);

void SumDarkness(const ImageView& image, const DarknessPatch* patches, int count,
                 DarknessSums* sums) {
  HWY_DYNAMIC_DISPATCH(SumDarkness)(image, patches, count, sums);
}

const char* CentroidTargetName() { return HWY_DYNAMIC_DISPATCH(CentroidTargetName)(); }

}  // namespace topotag
#endif  // HWY_ONCE
