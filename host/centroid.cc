#include "host/centroid.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "host/centroid.cc"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <cstdlib>
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
// Rows summed in 32 bits before they are added up in 64: a pixel's s is below 2^14.
constexpr int kMaxRows = 64;
constexpr int kShift = 8;  // of LinearValue

using D16 = hn::CappedTag<int16_t, kMaxLanes>;
using DU16 = hn::RebindToUnsigned<D16>;
using D32 = hn::RepartitionToWide<D16>;
using D8 = hn::Rebind<uint8_t, D16>;
using V16 = hn::Vec<D16>;

// The part of a linear value that depends on the column: of dx its multiple of 2^8 and the rest
// apart, which 16 bits hold.
HWY_INLINE V16 Along(const LinearValue& value, V16 columns) {
  const D16 d;
  const V16 rest = hn::Set(d, static_cast<int16_t>((value.dx & 0xff) << 7));
  return hn::Add(hn::Mul(columns, hn::Set(d, static_cast<int16_t>(value.dx >> kShift))),
                 hn::MulFixedPoint15(columns, rest));
}

HWY_INLINE V16 AtRow(int32_t value) {
  return hn::Set(D16(), static_cast<int16_t>(value >> kShift));
}

// Between 0 and `one`.
HWY_INLINE V16 Inside(V16 distance, V16 reach, V16 one) {
  const DU16 du;
  const auto inside = hn::SaturatedSub(hn::BitCast(du, reach), hn::BitCast(du, hn::Abs(distance)));
  return hn::Min(hn::BitCast(D16(), inside), one);
}

int64_t Total(hn::Vec<D32> sums) { return hn::GetLane(hn::SumOfLanes(D32(), sums)); }

// Sums over the rows [y, y + rows) of the patch and as many columns, from x on, as there are lanes.
// `pixels` is the first of them.
void SumTile(const DarknessPatch& patch, const uint8_t* pixels, ptrdiff_t stride, int x, int y,
             int rows, DarknessSums* sums) {
  const D16 d;
  const D32 d32;
  const V16 lane = hn::Load(d, kColumns);
  const V16 columns = hn::Add(lane, hn::Set(d, static_cast<int16_t>(x)));
  const V16 u_x = Along(patch.u, columns);
  const V16 v_x = Along(patch.v, columns);
  const V16 white_x = Along(patch.inverse_white, columns);
  const V16 reach_u = hn::Set(d, patch.reach_u);
  const V16 reach_v = hn::Set(d, patch.reach_v);
  const V16 one = hn::Set(d, patch.one);
  const V16 black = hn::Set(d, patch.black);
  const V16 ones = hn::Set(d, 1);
  int32_t u = patch.u.base + y * patch.u.dy;
  int32_t v = patch.v.base + y * patch.v.dy;
  int32_t white = patch.inverse_white.base + y * patch.inverse_white.dy;
  auto sum = hn::Zero(d32);
  auto sum_high = hn::Zero(d32);
  auto sum_x = hn::Zero(d32);
  auto sum_x_high = hn::Zero(d32);
  auto running = hn::Zero(d32);  // row r enters rows - r times
  for (int r = 0; r < rows; ++r) {
    const V16 grey = hn::ShiftLeft<7>(hn::PromoteTo(d, hn::LoadU(D8(), pixels)));
    const V16 relative = hn::MulFixedPoint15(grey, hn::Add(AtRow(white), white_x));
    const V16 weight = hn::Mul(Inside(hn::Add(AtRow(u), u_x), reach_u, one),
                               Inside(hn::Add(AtRow(v), v_x), reach_v, one));
    const V16 s = hn::MulFixedPoint15(weight, hn::Sub(black, relative));
    sum = hn::ReorderWidenMulAccumulate(d32, s, ones, sum, sum_high);
    sum_x = hn::ReorderWidenMulAccumulate(d32, s, lane, sum_x, sum_x_high);
    running = hn::Add(running, hn::Add(sum, sum_high));
    pixels += stride;
    u += patch.u.dy;
    v += patch.v.dy;
    white += patch.inverse_white.dy;
  }
  const int64_t total = Total(hn::Add(sum, sum_high));
  sums->sum += total;
  sums->x += Total(hn::Add(sum_x, sum_x_high)) + x * total;
  sums->y += (y + rows) * total - Total(running);
}

// Where the image is too narrow for a tile, its pixels are copied to a wider one; what is beyond
// the patch has no weight.
void SumNarrowTile(const DarknessPatch& patch, const uint8_t* pixels, ptrdiff_t stride, int width,
                   int x, int y, int rows, DarknessSums* sums) {
  HWY_ALIGN uint8_t copy[kMaxRows * kMaxLanes] = {};
  for (int r = 0; r < rows; ++r) {
    std::memcpy(copy + r * kMaxLanes, pixels + r * stride, static_cast<size_t>(width));
  }
  SumTile(patch, copy, kMaxLanes, x, y, rows, sums);
}

DarknessSums SumPatch(const ImageView& image, const DarknessPatch& patch) {
  DarknessSums sums;
  const int lanes = static_cast<int>(hn::Lanes(D16()));
  const int tiles = (patch.width + lanes - 1) / lanes;
  for (int y = 0; y < patch.height; y += kMaxRows) {
    const int rows = std::min(kMaxRows, patch.height - y);
    // Whole tiles that cover the patch, moved left where they would leave the image.
    int x = std::min(0, image.width - patch.x - tiles * lanes);
    const uint8_t* row = image.row(patch.y + y) + patch.x;
    if (patch.x + x < 0) {
      for (x = 0; x < patch.width; x += lanes) {
        SumNarrowTile(patch, row + x, image.stride, std::min(lanes, patch.width - x), x, y, rows,
                      &sums);
      }
      continue;
    }
    for (int tile = 0; tile < tiles; ++tile, x += lanes) {
      SumTile(patch, row + x, image.stride, x, y, rows, &sums);
    }
  }
  return sums;
}

void SumDarkness(const ImageView& image, const DarknessPatch* patches, int count,
                 DarknessSums* sums) {
  for (int i = 0; i < count; ++i) {
    sums[i] = patches[i].width > 0 ? SumPatch(image, patches[i]) : DarknessSums();
  }
}

// Points of a ring in the order of their sides.
constexpr int32_t kRingA[kRingPoints] = {-3, -1, 1, 3, 4, 4, 4, 4, 3, 1, -1, -3, -4, -4, -4, -4};
constexpr int32_t kRingB[kRingPoints] = {-4, -4, -4, -4, -3, -1, 1, 3, 4, 4, 4, 4, 3, 1, -1, -3};

using DP = hn::CappedTag<int32_t, kRingPoints>;
using VP = hn::Vec<DP>;

// The places of both rings' points, within the image.
struct Places {
  HWY_ALIGN int32_t x[2 * kRingPoints];
  HWY_ALIGN int32_t y[2 * kRingPoints];
};

HWY_INLINE VP Within(VP place, int size) {
  const DP d;
  return hn::Min(hn::Max(place, hn::Zero(d)), hn::Set(d, (size - 1) << kRingShift));
}

void FindPlaces(const ImageView& image, int32_t x, int32_t y, const Ring rings[2], Places* places) {
  const DP d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int i = 0; i < 2 * kRingPoints; i += lanes) {
    const Ring& ring = rings[i / kRingPoints];
    const VP a = hn::LoadU(d, kRingA + i % kRingPoints);
    const VP b = hn::LoadU(d, kRingB + i % kRingPoints);
    const VP px = hn::Add(hn::Mul(a, hn::Set(d, ring.ux)), hn::Mul(b, hn::Set(d, ring.vx)));
    const VP py = hn::Add(hn::Mul(a, hn::Set(d, ring.uy)), hn::Mul(b, hn::Set(d, ring.vy)));
    hn::Store(Within(hn::Add(hn::Set(d, x), px), image.width), d, places->x + i);
    hn::Store(Within(hn::Add(hn::Set(d, y), py), image.height), d, places->y + i);
  }
}

// The four pixels around each place, a byte each: upper left, upper right, lower left, lower right.
// @tparam kInside  all of them are in the image; else the pixels of its border stand for those
// right
//         of and below it
template <bool kInside>
HWY_INLINE void LoadPixels(const ImageView& image, const Places& places, uint32_t* quads) {
  for (int i = 0; i < 2 * kRingPoints; ++i) {
    const int32_t x = places.x[i] >> kRingShift;
    const int32_t y = places.y[i] >> kRingShift;
    const uint8_t* upper = image.row(y) + x;
    const uint8_t* lower = kInside || y + 1 < image.height ? upper + image.stride : upper;
    const int right = kInside || x + 1 < image.width ? 1 : 0;
    const uint32_t upper_row = static_cast<uint32_t>(upper[0] | upper[right] << 8);
    const uint32_t lower_row = static_cast<uint32_t>(lower[0] | lower[right] << 8);
    quads[i] = upper_row | lower_row << 16;
  }
}

bool IsInside(const ImageView& image, int32_t x, int32_t y, const Ring& ring) {
  const int64_t reach_x = 4 * (int64_t{std::abs(ring.ux)} + std::abs(ring.vx));
  const int64_t reach_y = 4 * (int64_t{std::abs(ring.uy)} + std::abs(ring.vy));
  return x >= reach_x && y >= reach_y && x + reach_x < int64_t{image.width - 1} << kRingShift &&
         y + reach_y < int64_t{image.height - 1} << kRingShift;
}

void SumRings(const ImageView& image, int32_t x, int32_t y, const Ring rings[2], RingSums sums[2]) {
  const DP d;
  const hn::RebindToUnsigned<DP> du;
  const hn::Repartition<uint16_t, DP> d16;
  const int lanes = static_cast<int>(hn::Lanes(d));
  Places places;
  FindPlaces(image, x, y, rings, &places);
  HWY_ALIGN uint32_t quads[2 * kRingPoints];
  if (IsInside(image, x, y, rings[0]) && IsInside(image, x, y, rings[1])) {
    LoadPixels<true>(image, places, quads);
  } else {
    LoadPixels<false>(image, places, quads);
  }
  const auto byte = hn::Set(d, 0xff);
  const auto bytes = hn::Set(d16, 0xff);
  for (int r = 0; r < 2; ++r) {
    auto sum = hn::Zero(d);
    auto sum_a = hn::Zero(d);
    auto sum_b = hn::Zero(d);
    for (int i = 0; i < kRingPoints; i += lanes) {
      const int k = r * kRingPoints + i;
      const auto fx = hn::And(hn::ShiftRight<kRingShift - 8>(hn::Load(d, places.x + k)), byte);
      const auto fy = hn::And(hn::ShiftRight<kRingShift - 8>(hn::Load(d, places.y + k)), byte);
      const auto quad = hn::BitCast(d16, hn::Load(du, quads + k));
      const auto left = hn::And(quad, bytes);
      const auto right = hn::ShiftRight<8>(quad);
      const auto both_fx = hn::BitCast(d16, hn::Or(fx, hn::ShiftLeft<16>(fx)));
      // Of the upper row in the lower 16 bits, of the lower row in the upper ones: below 2^16.
      const auto rows =
          hn::BitCast(d, hn::Add(hn::ShiftLeft<8>(left), hn::Mul(hn::Sub(right, left), both_fx)));
      const auto upper = hn::And(rows, hn::Set(d, 0xffff));
      const auto lower = hn::BitCast(d, hn::ShiftRight<16>(hn::BitCast(du, rows)));
      const auto mixed = hn::Mul(hn::Sub(lower, upper), fy);
      const auto level = hn::ShiftRight<8>(hn::Add(hn::ShiftLeft<8>(upper), mixed));
      sum = hn::Add(sum, level);
      sum_a = hn::Add(sum_a, hn::Mul(level, hn::LoadU(d, kRingA + i)));
      sum_b = hn::Add(sum_b, hn::Mul(level, hn::LoadU(d, kRingB + i)));
    }
    sums[r] = {hn::GetLane(hn::SumOfLanes(d, sum)), hn::GetLane(hn::SumOfLanes(d, sum_a)),
               hn::GetLane(hn::SumOfLanes(d, sum_b))};
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
HWY_EXPORT(SumRings);
HWY_EXPORT(CentroidTargetName);

void SumDarkness(const ImageView& image, const DarknessPatch* patches, int count,
                 DarknessSums* sums) {
  HWY_DYNAMIC_DISPATCH(SumDarkness)(image, patches, count, sums);
}

void SumRings(const ImageView& image, int32_t x, int32_t y, const Ring rings[2], RingSums sums[2]) {
  HWY_DYNAMIC_DISPATCH(SumRings)(image, x, y, rings, sums);
}

const char* CentroidTargetName() { return HWY_DYNAMIC_DISPATCH(CentroidTargetName)(); }

}  // namespace topotag
#endif  // HWY_ONCE
