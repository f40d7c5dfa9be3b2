// The normal distribution function in vectors, and what photometric kernels share. Included once
// for each Highway target.

#if defined(TOPOTAG_HOST_PHOTOMETRIC_PROFILE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TOPOTAG_HOST_PHOTOMETRIC_PROFILE_INL_H_
#undef TOPOTAG_HOST_PHOTOMETRIC_PROFILE_INL_H_
#else
#define TOPOTAG_HOST_PHOTOMETRIC_PROFILE_INL_H_
#endif

#include <hwy/highway.h>

#include "host/photometric_model.h"

HWY_BEFORE_NAMESPACE();
namespace topotag {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using hn::Add;
using hn::Mul;
using hn::Sub;
using D = hn::CappedTag<float, kPixelLanes>;
using V = hn::Vec<D>;

constexpr float kRoots[] = {0,           1,           1.41421356f, 1.73205081f, 2,
                            2.23606798f, 2.44948974f, 2.64575131f, 2.82842712f, 3,
                            3.16227766f, 3.31662479f, 3.46410162f};

HWY_INLINE V Const(float value) { return hn::Set(D(), value); }
// Two roundings on every target.
HWY_INLINE V MulThenAdd(V a, V b, V c) { return hn::Add(hn::Mul(a, b), c); }

// exp(-x), x >= 0; at least 2^-40, so that products of it stay normal numbers.
HWY_INLINE V ExpOfMinus(V x) {
  const D d;
  const V scaled = hn::Max(Mul(x, Const(-1.44269504f)), Const(-40.0f));
  const V whole = hn::Round(scaled);
  const V f = Sub(scaled, whole);
  V p = Const(1.54035304e-4f);
  p = MulThenAdd(p, f, Const(1.33335581e-3f));
  p = MulThenAdd(p, f, Const(9.61812911e-3f));
  p = MulThenAdd(p, f, Const(5.55041087e-2f));
  p = MulThenAdd(p, f, Const(2.40226507e-1f));
  p = MulThenAdd(p, f, Const(6.93147181e-1f));
  p = MulThenAdd(p, f, Const(1.0f));
  const auto exponent = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(hn::RebindToSigned<D>(), whole),
                                                  hn::Set(hn::RebindToSigned<D>(), 127)));
  return Mul(p, hn::BitCast(d, exponent));
}

// Beyond, the normal distribution function is taken for 0 or 1.
constexpr float kFarthest = 4;

// The normal distribution function, to 5e-6, and its density, to 2e-4: least maximum errors.
HWY_INLINE void Normal(V x, V* distribution, V* density) {
  const V s = Mul(x, x);
  V p = Const(8.06280383e-11f), q = Const(-1.93974034e-8f);
  p = MulThenAdd(p, s, Const(-7.00305399e-9f));
  p = MulThenAdd(p, s, Const(2.71604224e-7f));
  q = MulThenAdd(q, s, Const(1.36172876e-6f));
  p = MulThenAdd(p, s, Const(-6.29483282e-6f));
  q = MulThenAdd(q, s, Const(-4.07218421e-5f));
  p = MulThenAdd(p, s, Const(9.8906694e-5f));
  q = MulThenAdd(q, s, Const(6.83194069e-4f));
  p = MulThenAdd(p, s, Const(-1.13391562e-3f));
  q = MulThenAdd(q, s, Const(-7.12594072e-3f));
  p = MulThenAdd(p, s, Const(9.87746085e-3f));
  q = MulThenAdd(q, s, Const(4.78356082e-2f));
  p = MulThenAdd(p, s, Const(-6.64105775e-2f));
  q = MulThenAdd(q, s, Const(-1.98112354e-1f));
  p = MulThenAdd(p, s, Const(3.98922704e-1f));
  *density = MulThenAdd(q, s, Const(3.98792131e-1f));
  *distribution = MulThenAdd(p, x, Const(0.5f));
}

// The normal distribution function of x, and its derivatives divided by sqrt(k!): of orders
// 0 .. count - 1.
HWY_INLINE void Profile(V x, int count, V* out) {
  x = hn::Min(hn::Max(x, Const(-kFarthest)), Const(kFarthest));
  Normal(x, &out[0], &out[1]);
  const V minus = hn::Neg(x);
  for (int k = 1; k + 1 < count; ++k) {
    const V next = Mul(Mul(minus, out[k]), Const(1 / kRoots[k + 1]));
    out[k + 1] =
        k == 1 ? next : Sub(next, Mul(out[k - 1], Const((k - 1) / (kRoots[k] * kRoots[k + 1]))));
  }
}

// Where a block of pixels looks at the tag.
struct View {
  HWY_INLINE View() {}  // an implicit one is not compiled for the target

  V u, v;                  // tag point
  V ux, uy, vx, vy;        // derivatives by the pixel
  V cuu, cuv, cvv;         // covariance of the point spread function
  V inverse_u, inverse_v;  // 1 / width of the point spread function along the axes
  V rho;                   // correlation
  V bend_u, bend_v;        // by which the covariance with the axes grows a unit
};

// What a pixel sees of a pattern, and its derivatives by the tag point and by the growth.
struct Coverage {
  HWY_INLINE Coverage() {}  // an implicit one is not compiled for the target

  V value, u, v, uu, uv, vv, growth;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace topotag
HWY_AFTER_NAMESPACE();

#endif  // per target
