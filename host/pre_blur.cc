#include "host/pre_blur.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "host/pre_blur.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace topotag {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::ScalableTag<uint16_t> kU16;
constexpr hn::Rebind<uint8_t, decltype(kU16)> kU8;

template <typename V>
HWY_INLINE V Binomial(V a, V b, V c, V d, V e) {
  const V twice = hn::Add(c, c);
  const V fours = hn::Add(hn::Add(b, d), c);
  return hn::Add(hn::Add(hn::Add(a, e), hn::ShiftLeft<2>(fours)), twice);
}

}  // namespace

// Sums along a row, 16 times a grey level. `in` has two more pixels on its left, and on its right
// as many as a vector besides.
void SumRow(const uint8_t* in, int width, uint16_t* out) {
  const int lanes = static_cast<int>(hn::Lanes(kU16));
  for (int i = 0; i < width; i += lanes) {
    const auto at = [&](int k) { return hn::PromoteTo(kU16, hn::LoadU(kU8, in + i + k)); };
    hn::StoreU(Binomial(at(-2), at(-1), at(0), at(1), at(2)), kU16, out + i);
  }
}

// Sums five rows: 256 times a grey level and half of that stay below 2^16. Rows have a vector's
// room behind them.
void SumRows(const uint16_t* const* rows, int width, uint8_t* out) {
  const int lanes = static_cast<int>(hn::Lanes(kU16));
  const auto half = hn::Set(kU16, 128);
  for (int i = 0; i < width; i += lanes) {
    const auto at = [&](int k) { return hn::LoadU(kU16, rows[k] + i); };
    const auto sum = hn::Add(Binomial(at(0), at(1), at(2), at(3), at(4)), half);
    const auto level = hn::BitCast(hn::RebindToSigned<decltype(kU16)>(), hn::ShiftRight<8>(sum));
    hn::StoreU(hn::DemoteTo(kU8, level), kU8, out + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace topotag
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag {
namespace {

HWY_EXPORT(SumRow);
HWY_EXPORT(SumRows);

constexpr size_t kReach = 2;
constexpr size_t kTaps = 2 * kReach + 1;
constexpr size_t kRoom = 256;  // bytes: no vector is longer
constexpr int kNoiseTile = 16;
// Above the quartile of the tiles' spans: the spans of noise alone scatter by a fifth.
constexpr int kNoisePercent = 140;

// Brightest minus darkest mean of two pixels, one above the other.
int Span(const ImageView& image, int x0, int y0) {
  int least = 255, most = 0;
  for (int y = y0; y < y0 + kNoiseTile; y += 2) {
    const uint8_t* upper = image.row(y) + x0;
    const uint8_t* lower = image.row(y + 1) + x0;
    for (int x = 0; x < kNoiseTile; ++x) {
      const int mean = (upper[x] + lower[x] + 1) / 2;
      least = std::min(least, mean);
      most = std::max(most, mean);
    }
  }
  return most - least;
}

}  // namespace

ImageView PreBlur(const ImageView& image, PreBlurWorkspace* workspace) {
  const auto width = static_cast<size_t>(image.width);
  const size_t stride = width + kRoom;
  const int height = image.height;
  workspace->padded.Reserve(width + 2 * kReach + 2 * kRoom);
  workspace->rows.Reserve(kTaps * stride);
  workspace->pixels.Reserve(stride * static_cast<size_t>(height));
  uint8_t* padded = workspace->padded.data();
  const auto sum_row = HWY_DYNAMIC_DISPATCH(SumRow);
  const auto sum_rows = HWY_DYNAMIC_DISPATCH(SumRows);
  const auto row = [&](int y) {
    return workspace->rows.data() + static_cast<size_t>(y) % kTaps * stride;
  };
  int summed = 0;
  for (int y = 0; y < height; ++y) {
    for (; summed < std::min(y + static_cast<int>(kReach) + 1, height); ++summed) {
      const uint8_t* in = image.row(summed);
      std::memset(padded, in[0], kReach);
      std::memcpy(padded + kReach, in, width);
      std::memset(padded + kReach + width, in[width - 1], kRoom);
      sum_row(padded + kReach, image.width, row(summed));
    }
    const uint16_t* rows[kTaps];
    for (size_t k = 0; k < kTaps; ++k) {
      rows[k] = row(std::clamp(y + static_cast<int>(k) - static_cast<int>(kReach), 0, height - 1));
    }
    sum_rows(rows, image.width, workspace->pixels.data() + static_cast<size_t>(y) * stride);
  }
  return {workspace->pixels.data(), image.width, height, static_cast<ptrdiff_t>(stride)};
}

int NoiseContrast(const ImageView& image) {
  int count[256] = {};
  int tiles = 0;
  for (int y = 0; y + kNoiseTile <= image.height; y += kNoiseTile) {
    for (int x = 0; x + kNoiseTile <= image.width; x += kNoiseTile) {
      ++count[Span(image, x, y)];
      ++tiles;
    }
  }
  int span = 0;
  for (int below = count[0]; span < 255 && 4 * below < tiles;) below += count[++span];
  return std::min(span * kNoisePercent / 100, 255);
}

}  // namespace topotag
#endif  // HWY_ONCE
