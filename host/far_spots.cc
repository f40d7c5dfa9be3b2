#include "host/far_spots.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "host/far_spots.cc"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace topotag {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Columns begin to end, a multiple of 8 and of at least as many as d has lanes.
template <class D>
HWY_INLINE void FindSpotsOf(D d, const ImageView& image, int y, int begin, int end, int step,
                            int depth, uint8_t* bits) {
  const auto lanes = static_cast<int>(hn::Lanes(d));
  const int reach = 2 * step;
  const uint8_t* mid = image.row(y);
  const uint8_t* near_above = image.row(y - step);
  const uint8_t* above = image.row(y - reach);
  const uint8_t* near_below = image.row(y + step);
  const uint8_t* below = image.row(y + reach);
  const auto less = hn::Set(d, static_cast<uint8_t>(depth - 1));
  for (int next = begin; next < end; next += lanes) {
    const int x = HWY_MIN(next, end - lanes);
    const auto l = hn::Max(hn::LoadU(d, mid + x - step), hn::LoadU(d, mid + x - reach));
    const auto r = hn::Max(hn::LoadU(d, mid + x + step), hn::LoadU(d, mid + x + reach));
    const auto a = hn::Max(hn::LoadU(d, near_above + x), hn::LoadU(d, above + x));
    const auto b = hn::Max(hn::LoadU(d, near_below + x), hn::LoadU(d, below + x));
    const auto least = hn::Min(hn::Min(l, r), hn::Min(a, b));
    const auto spot = hn::Gt(hn::SaturatedSub(least, hn::LoadU(d, mid + x)), less);
    hn::StoreMaskBits(d, spot, bits + x / 8);
  }
}

}  // namespace

void FindSpots(const ImageView& image, int y, int x0, int x1, int step, int depth, uint8_t* bits) {
  std::fill(bits + x0 / 8, bits + (x1 + 7) / 8, uint8_t{0});
  const int begin = std::max(x0, kSpotBorder);
  const int end = std::min((x1 + 7) / 8 * 8, (image.width - kSpotBorder) / 8 * 8);
  if (y < kSpotBorder || y >= image.height - kSpotBorder || begin >= end) return;
  const hn::ScalableTag<uint8_t> d;
  const hn::CappedTag<uint8_t, 16> d16;
  const hn::CappedTag<uint8_t, 8> d8;
  if (end - begin >= static_cast<int>(hn::Lanes(d))) {
    FindSpotsOf(d, image, y, begin, end, step, depth, bits);
  } else if (end - begin >= 16) {
    FindSpotsOf(d16, image, y, begin, end, step, depth, bits);
  } else {
    FindSpotsOf(d8, image, y, begin, end, step, depth, bits);
  }
}

void HalveRow(const ImageView& image, int y, int x0, int count, uint8_t* out) {
  const uint8_t* upper = image.row(2 * y) + 2 * x0;
  const uint8_t* lower = image.row(2 * y + 1) + 2 * x0;
  const hn::ScalableTag<uint16_t> d16;
  const hn::RebindToSigned<decltype(d16)> signed16;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const hn::Repartition<uint8_t, decltype(d16)> bytes;
  const auto lanes = static_cast<int>(hn::Lanes(d16));
  const auto mask = hn::Set(d16, 0xff);
  const auto emit_vector = [&](int x) {
    const auto a = hn::BitCast(d16, hn::LoadU(bytes, upper + 2 * x));
    const auto b = hn::BitCast(d16, hn::LoadU(bytes, lower + 2 * x));
    const auto sum = hn::Add(hn::Add(hn::And(a, mask), hn::ShiftRight<8>(a)),
                             hn::Add(hn::And(b, mask), hn::ShiftRight<8>(b)));
    const auto mean = hn::ShiftRight<2>(hn::Add(sum, hn::Set(d16, 2)));
    hn::StoreU(hn::DemoteTo(d8, hn::BitCast(signed16, mean)), d8, out + x);
  };
  if (count >= lanes) {
    // The last vector overlaps the one before.
    for (int next = 0; next < count; next += lanes) emit_vector(HWY_MIN(next, count - lanes));
    return;
  }
  for (int x = 0; x < count; ++x) {
    const int sum = upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1];
    out[x] = static_cast<uint8_t>((sum + 2) >> 2);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace topotag
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag {

HWY_EXPORT(FindSpots);
HWY_EXPORT(HalveRow);

void FindSpots(const ImageView& image, int y, int x0, int x1, int step, int depth, uint8_t* bits) {
  HWY_DYNAMIC_DISPATCH(FindSpots)(image, y, x0, x1, step, depth, bits);
}

void HalveRow(const ImageView& image, int y, int x0, int count, uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(HalveRow)(image, y, x0, count, out);
}

}  // namespace topotag
#endif  // HWY_ONCE
