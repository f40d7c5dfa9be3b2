#include "host/upsample.h"

#include <algorithm>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "host/upsample.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace topotag {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::ScalableTag<int32_t> kI32;
constexpr hn::Rebind<int16_t, decltype(kI32)> kI16;
constexpr hn::Rebind<uint8_t, decltype(kI32)> kU8;

using Ints = hn::Vec<decltype(kI32)>;

// Catmull-Rom a quarter of a pixel right of the second of four samples, in 128ths.
int Cubic(int a, int b, int c, int d) { return -9 * a + 111 * b + 29 * c - 3 * d; }

Ints Cubic(Ints a, Ints b, Ints c, Ints d) {
  const auto plus = hn::Add(hn::Mul(b, hn::Set(kI32, 111)), hn::Mul(c, hn::Set(kI32, 29)));
  const auto minus = hn::Add(hn::Mul(a, hn::Set(kI32, 9)), hn::Mul(d, hn::Set(kI32, 3)));
  return hn::Sub(plus, minus);
}

}  // namespace

// Doubles one row, to 8ths of a grey level, which 16 bits hold with the overshoot: even results lie
// a quarter left of a pixel, odd ones a quarter right of it.
void DoubleRow(const uint8_t* in, int width, int16_t* out) {
  const auto emit_one = [&](int i) {
    const auto at = [&](int k) { return int{in[std::clamp(i + k, 0, width - 1)]}; };
    out[2 * i] = static_cast<int16_t>((Cubic(at(1), at(0), at(-1), at(-2)) + 8) >> 4);
    out[2 * i + 1] = static_cast<int16_t>((Cubic(at(-1), at(0), at(1), at(2)) + 8) >> 4);
  };
  const int lanes = static_cast<int>(hn::Lanes(kI32));
  const auto half = hn::Set(kI32, 8);
  int i = 0;
  for (; i < std::min(2, width); ++i) emit_one(i);
  for (; i + lanes + 2 <= width; i += lanes) {
    const auto at = [&](int k) { return hn::PromoteTo(kI32, hn::LoadU(kU8, in + i + k)); };
    const auto left = Cubic(at(1), at(0), at(-1), at(-2));
    const auto right = Cubic(at(-1), at(0), at(1), at(2));
    hn::StoreInterleaved2(hn::DemoteTo(kI16, hn::ShiftRight<4>(hn::Add(left, half))),
                          hn::DemoteTo(kI16, hn::ShiftRight<4>(hn::Add(right, half))), kI16,
                          out + 2 * i);
  }
  for (; i < width; ++i) emit_one(i);
}

// Pixels a quarter below row b, towards row c.
void MixRows(const int16_t* a, const int16_t* b, const int16_t* c, const int16_t* d, int width,
             uint8_t* out) {
  const int lanes = static_cast<int>(hn::Lanes(kI32));
  const auto half = hn::Set(kI32, 512);
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    const auto at = [&](const int16_t* row) {
      return hn::PromoteTo(kI32, hn::LoadU(kI16, row + x));
    };
    const auto sum = hn::Add(Cubic(at(a), at(b), at(c), at(d)), half);
    hn::StoreU(hn::DemoteTo(kU8, hn::ShiftRight<10>(sum)), kU8, out + x);
  }
  for (; x < width; ++x) {
    const int sum = Cubic(int{a[x]}, int{b[x]}, int{c[x]}, int{d[x]}) + 512;
    out[x] = static_cast<uint8_t>(std::clamp(sum >> 10, 0, 255));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace topotag
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag {
namespace {

HWY_EXPORT(DoubleRow);
HWY_EXPORT(MixRows);

}  // namespace

ImageView Upsample(const ImageView& image, UpsampleWorkspace* workspace) {
  const int width = 2 * image.width;
  const int height = 2 * image.height;
  workspace->rows.resize(static_cast<size_t>(width) * static_cast<size_t>(image.height));
  workspace->pixels.resize(static_cast<size_t>(width) * static_cast<size_t>(height));
  const auto row = [&](int y) {
    return workspace->rows.data() +
           static_cast<ptrdiff_t>(std::clamp(y, 0, image.height - 1)) * width;
  };
  for (int y = 0; y < image.height; ++y) {
    HWY_DYNAMIC_DISPATCH(DoubleRow)(image.row(y), image.width, row(y));
  }
  const auto mix = HWY_DYNAMIC_DISPATCH(MixRows);
  uint8_t* out = workspace->pixels.data();
  for (int y = 0; y < image.height; ++y, out += 2 * static_cast<ptrdiff_t>(width)) {
    mix(row(y + 1), row(y), row(y - 1), row(y - 2), width, out);
    mix(row(y - 1), row(y), row(y + 1), row(y + 2), width, out + width);
  }
  return {workspace->pixels.data(), width, height, width};
}

}  // namespace topotag
#endif  // HWY_ONCE
