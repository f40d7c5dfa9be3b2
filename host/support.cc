#include "host/support.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace topotag {
namespace {

// Fixed point: 16 bits, of which so many are used.
constexpr float kMaxFixed = 32000;
// Pixels beside a patch that are computed too, without weight.
constexpr float kOverhang = 32;
// One pixel of distance, at most.
constexpr float kOnePixel = 1 << 7;
// Distance from the support to the patch's edge, in pixels / `one`: more than a distance in fixed
// point is off, so that what lies beyond the patch has no weight.
constexpr float kMargin = 6;

// Supports with more rows than the first of these have rows left out, so that the second one is
// kept to: a third of the time, at up to 1.4 times the error of a vertex, which is below 1e-3 units
// there.
constexpr int kMaxAllRows = 256;
constexpr int kFewRows = 128;

// What the patches are made of, in arrays, so that a loop takes several at a time.
struct Parts {
  float wide[kMaxPoints], high[kMaxPoints];  // half sides of the patch, pixels
  float one[kMaxPoints], black[kMaxPoints];
  // Distances and darkness, times their fixed point.
  float reach_u[kMaxPoints], reach_v[kMaxPoints];
  float u_dx[kMaxPoints], u_dy[kMaxPoints], v_dx[kMaxPoints], v_dy[kMaxPoints];
  float white[kMaxPoints], white_dx[kMaxPoints], white_dy[kMaxPoints];
};

// The largest power of 2, at most `limit`, times which `bound` is at most `max`; `max` / `bound` is
// positive.
inline float FixedOne(float bound, float limit, float max) {
  constexpr uint32_t kExponent = 0x7f800000;
  const float ratio = max / bound;
  uint32_t bits;
  std::memcpy(&bits, &ratio, sizeof(bits));
  bits &= kExponent;
  float power;
  std::memcpy(&power, &bits, sizeof(power));
  return power < limit ? power : limit;
}

void FindParts(const Supports& s, int count, Parts* parts) {
  Parts& p = *parts;
  for (int i = 0; i < count; ++i) {
    const float xu = s.xu[i], xv = s.xv[i], yu = s.yu[i], yv = s.yv[i];
    const float det = xu * yv - xv * yu;
    const float area = std::abs(det);
    const float inverse_det = 1 / det;
    // Pixels across which u grows by one unit are area / length_u.
    const float length_u = std::sqrt(yv * yv + xv * xv);
    const float length_v = std::sqrt(xu * xu + yu * yu);
    const float inverse_u = 1 / length_u;
    const float inverse_v = 1 / length_v;
    const float delta = SupportGrowth(area, s.half_y[i]);
    const float reach_u = s.half_x[i] + delta + 0.5F * length_u * std::abs(inverse_det);
    const float reach_v = s.half_y[i] + delta + 0.5F * length_v * std::abs(inverse_det);
    const float wide = reach_u * std::abs(xu) + reach_v * std::abs(xv);
    const float high = reach_u * std::abs(yu) + reach_v * std::abs(yv);
    // The distances grow by 1 a pixel.
    const float bound = wide + high + kMargin + kOverhang;
    const float one = FixedOne(bound, kOnePixel, kMaxFixed);
    p.wide[i] = wide + kMargin / one;
    p.high[i] = high + kMargin / one;
    const float scale = 256 * one;
    p.u_dx[i] = yv * inverse_u * scale;
    p.u_dy[i] = -xv * inverse_u * scale;
    p.v_dx[i] = -yu * inverse_v * scale;
    p.v_dy[i] = xu * inverse_v * scale;
    p.reach_u[i] = reach_u * inverse_u * area * one;
    p.reach_v[i] = reach_v * inverse_v * area * one;
    p.one[i] = one;
    // 1 / white, to first order in the shading.
    const float inverse_level = 1 / s.white[i];
    const float per_unit = -inverse_level * inverse_level * inverse_det;
    const float dx = (s.white_u[i] * yv - s.white_v[i] * yu) * per_unit;
    const float dy = (s.white_v[i] * xu - s.white_u[i] * xv) * per_unit;
    const float largest = 256 * (inverse_level + std::abs(dx) * wide + std::abs(dy) * high);
    const float black = FixedOne(largest, kMaxBlack, kMaxRelative);
    const float white_scale = 65536 * black;
    p.white[i] = inverse_level * white_scale;
    p.white_dx[i] = dx * white_scale;
    p.white_dy[i] = dy * white_scale;
    p.black[i] = black;
  }
}

// A function of the pixel with the value `level` at `center`, in 2^-8 of its fixed point.
LinearValue FixedLinear(Point2 center, float level, float dx, float dy) {
  return {static_cast<int32_t>(level - dx * center.x - dy * center.y) + 128,
          static_cast<int32_t>(dx), static_cast<int32_t>(dy)};
}

}  // namespace

void MakePatches(const ImageView& image, const Supports& supports, const double* x, const double* y,
                 int count, DarknessPatch* patches) {
  Parts p;
  FindParts(supports, count, &p);
  for (int i = 0; i < count; ++i) {
    DarknessPatch& patch = patches[i];
    patch.width = 0;
    const bool fits = p.one[i] >= 1 && p.black[i] >= 1;
    if (!fits || !(std::abs(x[i]) < 2 * kMaxImageSide && std::abs(y[i]) < 2 * kMaxImageSide)) {
      continue;
    }
    patch.x = std::max(static_cast<int>(x[i] - p.wide[i]) + 1, 0);
    patch.y = std::max(static_cast<int>(y[i] - p.high[i]) + 1, 0);
    const int x_end = std::min(static_cast<int>(x[i] + p.wide[i]) + 1, image.width);
    patch.height = std::min(static_cast<int>(y[i] + p.high[i]) + 1, image.height) - patch.y;
    if (patch.height <= 0 || x_end <= patch.x) continue;
    patch.width = x_end - patch.x;
    patch.step = 1;
    if (patch.height > kMaxAllRows) {
      while (patch.height > kFewRows * patch.step && patch.step < kMaxStep) patch.step *= 2;
    }
    const Point2 center{x[i] - patch.x, y[i] - patch.y};
    patch.u = FixedLinear(center, 0, p.u_dx[i], p.u_dy[i]);
    patch.v = FixedLinear(center, 0, p.v_dx[i], p.v_dy[i]);
    patch.reach_u = static_cast<int16_t>(p.reach_u[i]);
    patch.reach_v = static_cast<int16_t>(p.reach_v[i]);
    patch.one = static_cast<int16_t>(p.one[i]);
    patch.inverse_white = FixedLinear(center, p.white[i], p.white_dx[i], p.white_dy[i]);
    patch.black = static_cast<int16_t>(p.black[i]);
  }
}

}  // namespace topotag
