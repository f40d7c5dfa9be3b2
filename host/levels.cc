#include "host/levels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "host/levels.cc"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace topotag {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Rings that each step is taken for before the next: what one waits for, the others fill.
constexpr int kBatch = 8;
constexpr int kBatchPoints = kBatch * kRingPoints;

// Points of a ring in the order of their sides.
HWY_ALIGN constexpr int32_t kRingA[kRingPoints] = {-3, -1, 1,  3,  4,  4,  4,  4,
                                                   3,  1,  -1, -3, -4, -4, -4, -4};
HWY_ALIGN constexpr int32_t kRingB[kRingPoints] = {-4, -4, -4, -4, -3, -1, 1,  3,
                                                   4,  4,  4,  4,  3,  1,  -1, -3};

using D = hn::CappedTag<int32_t, kRingPoints>;
using V = hn::Vec<D>;

// Places within the image, where the pixel left of and above each lies in its memory (if 32 bits
// hold that), and the four pixels around each, a byte each: upper left, upper right, lower left,
// lower right.
struct Samples {
  HWY_ALIGN int32_t x[kBatchPoints];
  HWY_ALIGN int32_t y[kBatchPoints];
  HWY_ALIGN int32_t offsets[kBatchPoints];
  HWY_ALIGN uint32_t quads[kBatchPoints];
};

HWY_INLINE V Within(V place, int size) {
  const D d;
  return hn::Min(hn::Max(place, hn::Zero(d)), hn::Set(d, (size - 1) << kPlaceShift));
}

// Stores places; returns whether all the pixels around them are in the image.
HWY_INLINE bool StorePlaces(const ImageView& image, V x, V y, int first, Samples* samples) {
  const D d;
  const V within_x = Within(x, image.width);
  const V within_y = Within(y, image.height);
  hn::Store(within_x, d, samples->x + first);
  hn::Store(within_y, d, samples->y + first);
  const V row = hn::Mul(hn::ShiftRight<kPlaceShift>(within_y),
                        hn::Set(d, static_cast<int32_t>(image.stride)));
  hn::Store(hn::Add(row, hn::ShiftRight<kPlaceShift>(within_x)), d, samples->offsets + first);
  const V room = hn::Min(hn::Sub(hn::Set(d, (image.width - 1) << kPlaceShift), within_x),
                         hn::Sub(hn::Set(d, (image.height - 1) << kPlaceShift), within_y));
  return hn::AllTrue(d, hn::Gt(room, hn::Zero(d)));
}

HWY_INLINE bool FindPlaces(const ImageView& image, const Ring& ring, int first, Samples* samples) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  bool inside = true;
  for (int i = 0; i < kRingPoints; i += lanes) {
    const V a = hn::Load(d, kRingA + i);
    const V b = hn::Load(d, kRingB + i);
    const V x = hn::Add(hn::Mul(a, hn::Set(d, ring.ux)), hn::Mul(b, hn::Set(d, ring.vx)));
    const V y = hn::Add(hn::Mul(a, hn::Set(d, ring.uy)), hn::Mul(b, hn::Set(d, ring.vy)));
    inside &= StorePlaces(image, hn::Add(hn::Set(d, ring.x), x), hn::Add(hn::Set(d, ring.y), y),
                          first + i, samples);
  }
  return inside;
}

HWY_INLINE uint32_t Quad(const uint8_t* upper, const uint8_t* lower, int right) {
  const uint32_t upper_row = static_cast<uint32_t>(upper[0] | upper[right] << 8);
  const uint32_t lower_row = static_cast<uint32_t>(lower[0] | lower[right] << 8);
  return upper_row | lower_row << 16;
}

// @param inside  all pixels are in the image; else those of its border stand for those right of and
//        below it
HWY_INLINE void LoadPixels(const ImageView& image, bool inside, int count, Samples* samples) {
  if (inside && int64_t{image.stride} * image.height <= std::numeric_limits<int32_t>::max()) {
    for (int i = 0; i < count; ++i) {
      const uint8_t* upper = image.data + samples->offsets[i];
      samples->quads[i] = Quad(upper, upper + image.stride, 1);
    }
    return;
  }
  for (int i = 0; i < count; ++i) {
    const int32_t x = samples->x[i] >> kPlaceShift;
    const int32_t y = samples->y[i] >> kPlaceShift;
    const uint8_t* upper = image.row(y) + x;
    const uint8_t* lower = y + 1 < image.height ? upper + image.stride : upper;
    samples->quads[i] = Quad(upper, lower, x + 1 < image.width ? 1 : 0);
  }
}

// The bilinear levels of as many points as there are lanes, from `first` on.
HWY_INLINE V LevelsAt(const Samples& samples, int first) {
  const D d;
  const hn::RebindToUnsigned<D> du;
  const hn::Repartition<uint16_t, D> d16;
  const V byte = hn::Set(d, 0xff);
  const V fx = hn::And(hn::ShiftRight<kPlaceShift - 8>(hn::Load(d, samples.x + first)), byte);
  const V fy = hn::And(hn::ShiftRight<kPlaceShift - 8>(hn::Load(d, samples.y + first)), byte);
  const auto quad = hn::BitCast(d16, hn::Load(du, samples.quads + first));
  const auto left = hn::And(quad, hn::Set(d16, 0xff));
  const auto right = hn::ShiftRight<8>(quad);
  const auto both_fx = hn::BitCast(d16, hn::Or(fx, hn::ShiftLeft<16>(fx)));
  // Of the upper row in the lower 16 bits, of the lower row in the upper ones: below 2^16.
  const V rows =
      hn::BitCast(d, hn::Add(hn::ShiftLeft<8>(left), hn::Mul(hn::Sub(right, left), both_fx)));
  const V upper = hn::And(rows, hn::Set(d, 0xffff));
  const V lower = hn::BitCast(d, hn::ShiftRight<16>(hn::BitCast(du, rows)));
  const V mixed = hn::Mul(hn::Sub(lower, upper), fy);
  return hn::ShiftRight<8>(hn::Add(hn::ShiftLeft<8>(upper), mixed));
}

HWY_INLINE RingSums SumLevels(const Samples& samples, int first) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  V sum = hn::Zero(d), sum_a = hn::Zero(d), sum_b = hn::Zero(d);
  for (int i = 0; i < kRingPoints; i += lanes) {
    const V level = LevelsAt(samples, first + i);
    sum = hn::Add(sum, level);
    sum_a = hn::Add(sum_a, hn::Mul(level, hn::Load(d, kRingA + i)));
    sum_b = hn::Add(sum_b, hn::Mul(level, hn::Load(d, kRingB + i)));
  }
  return {hn::GetLane(hn::SumOfLanes(d, sum)), hn::GetLane(hn::SumOfLanes(d, sum_a)),
          hn::GetLane(hn::SumOfLanes(d, sum_b))};
}

void SumRings(const ImageView& image, const Ring* rings, int count, RingSums* sums) {
  Samples samples;
  for (int begin = 0; begin < count; begin += kBatch) {
    const int size = std::min(kBatch, count - begin);
    bool inside = true;
    for (int i = 0; i < size; ++i) {
      inside &= FindPlaces(image, rings[begin + i], i * kRingPoints, &samples);
    }
    LoadPixels(image, inside, size * kRingPoints, &samples);
    for (int i = 0; i < size; ++i) sums[begin + i] = SumLevels(samples, i * kRingPoints);
  }
}

void SampleLevels(const ImageView& image, const int32_t* x, const int32_t* y, int count,
                  int32_t* levels) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  Samples samples;
  for (int begin = 0; begin < count; begin += kRingPoints) {
    bool inside = true;
    for (int i = 0; i < kRingPoints; i += lanes) {
      inside &=
          StorePlaces(image, hn::LoadU(d, x + begin + i), hn::LoadU(d, y + begin + i), i, &samples);
    }
    LoadPixels(image, inside, kRingPoints, &samples);
    for (int i = 0; i < kRingPoints; i += lanes) {
      hn::StoreU(LevelsAt(samples, i), d, levels + begin + i);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace topotag
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag {

HWY_EXPORT(SumRings);
HWY_EXPORT(SampleLevels);

void SumRings(const ImageView& image, const Ring* rings, int count, RingSums* sums) {
  HWY_DYNAMIC_DISPATCH(SumRings)(image, rings, count, sums);
}

void SampleLevels(const ImageView& image, const int32_t* x, const int32_t* y, int count,
                  int32_t* levels) {
  HWY_DYNAMIC_DISPATCH(SampleLevels)(image, x, y, count, levels);
}

}  // namespace topotag
#endif  // HWY_ONCE
