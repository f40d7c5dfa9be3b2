#include "host/photometric_model.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "host/photometric_model.cc"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>

#include "host/photometric_chord-inl.h"
#include "host/photometric_profile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace topotag {
namespace HWY_NAMESPACE {
namespace {

constexpr int kMaxOrder = kMaxPhotometricOrder;
// Second derivatives serve the blur's unknowns alone.
constexpr int kSecondOrder = 2;
// The order of nearly all views is known to the compiler.
constexpr int kLowOrder = 2;
constexpr int kAnyOrder = 0;

HWY_INLINE View LookAt(const float* fields, bool has_lens, const PhotometricModel& m) {
  const D d;
  const auto field = [&](PixelField f) HWY_ATTR { return hn::Load(d, fields + f * kPixelLanes); };
  const V x = field(kPixelX);
  const V y = field(kPixelY);
  const auto row = [&](const std::array<float, 3>& r) HWY_ATTR {
    return MulThenAdd(y, Const(r[2]), MulThenAdd(x, Const(r[1]), Const(r[0])));
  };
  const V scale = hn::Div(Const(1), row(m.w));
  View view;
  view.u = Mul(row(m.u), scale);
  view.v = Mul(row(m.v), scale);
  V hx = Mul(Const(m.w[1]), scale);
  V hy = Mul(Const(m.w[2]), scale);
  view.ux = Sub(Mul(Const(m.u[1]), scale), Mul(view.u, hx));
  view.uy = Sub(Mul(Const(m.u[2]), scale), Mul(view.u, hy));
  view.vx = Sub(Mul(Const(m.v[1]), scale), Mul(view.v, hx));
  view.vy = Sub(Mul(Const(m.v[2]), scale), Mul(view.v, hy));
  if (has_lens) {
    const V xx = field(kPixelLensXx), xy = field(kPixelLensXy);
    const V yx = field(kPixelLensYx), yy = field(kPixelLensYy);
    const auto chain = [&](V* a, V* b) HWY_ATTR {
      const V first = Add(Mul(*a, xx), Mul(*b, yx));
      *b = Add(Mul(*a, xy), Mul(*b, yy));
      *a = first;
    };
    chain(&view.ux, &view.uy);
    chain(&view.vx, &view.vy);
    chain(&hx, &hy);
  }
  const V sxx = Const(m.blur_xx), sxy = Const(m.blur_xy), syy = Const(m.blur_yy);
  const V su_x = Add(Mul(sxx, view.ux), Mul(sxy, view.uy));
  const V su_y = Add(Mul(sxy, view.ux), Mul(syy, view.uy));
  const V sv_x = Add(Mul(sxx, view.vx), Mul(sxy, view.vy));
  const V sv_y = Add(Mul(sxy, view.vx), Mul(syy, view.vy));
  const V cuu = Add(Mul(su_x, view.ux), Mul(su_y, view.uy));
  const V cuv = Add(Mul(su_x, view.vx), Mul(su_y, view.vy));
  const V cvv = Add(Mul(sv_x, view.vx), Mul(sv_y, view.vy));
  view.cuu = cuu;
  view.cuv = cuv;
  view.cvv = cvv;
  const V inverse = hn::Div(Const(1), Mul(cuu, cvv));
  view.inverse_u = hn::Sqrt(Mul(inverse, cvv));
  view.inverse_v = hn::Sqrt(Mul(inverse, cuu));
  view.rho = Mul(cuv, Mul(view.inverse_u, view.inverse_v));
  view.bend_u = Add(Mul(su_x, hx), Mul(su_y, hy));
  view.bend_v = Add(Mul(sv_x, hx), Mul(sv_y, hy));
  return view;
}

// Profiles of the lines around a block of pixels.
template <int kLines>
struct Lines {
  HWY_INLINE Lines() {}  // an implicit one is not compiled for the target

  V p[kLines][kMaxOrder + 3];
  V q[kLines][kMaxOrder + 3];
  V sign_u, sign_v;  // of the first line's growth; it alternates
};

// Lines lie at odd halves; black grows towards +u over those above an odd cell.
template <int kLines, int kOrder>
HWY_INLINE void FindLines(const float* fields, const View& view, V growth, int any_order,
                          Lines<kLines>* lines) {
  const D d;
  const int order = kOrder == kAnyOrder ? any_order : kOrder;
  const auto along = [&](V place, V inverse_width, V bend, PixelField cell_field, V* sign,
                         V(*out)[kMaxOrder + 3]) HWY_ATTR {
    const V cell = hn::Load(d, fields + cell_field * kPixelLanes);
    const V first = Sub(cell, Const(static_cast<float>(kLines / 2)));
    const V half = Mul(first, Const(0.5f));
    // +1 where `first` is odd, else -1.
    *sign = Sub(Mul(Sub(half, hn::Floor(half)), Const(4)), Const(1));
    V shift = Mul(*sign, growth);
    const V growth_of_width = Mul(bend, Mul(inverse_width, inverse_width));
    const V offset = Sub(place, Add(first, Const(0.5f)));
    for (int i = 0; i < kLines; ++i) {
      const V x = Sub(Sub(offset, Const(static_cast<float>(i))), shift);
      // The width is that at the line, to first order: lines stay straight in the image.
      const V straight = Sub(Const(1), Mul(growth_of_width, x));
      Profile(Mul(Mul(x, inverse_width), straight), order + 3, out[i]);
      shift = hn::Neg(shift);
    }
  };
  along(view.u, view.inverse_u, view.bend_u, kPixelU, &lines->sign_u, lines->p);
  along(view.v, view.inverse_v, view.bend_v, kPixelV, &lines->sign_v, lines->q);
}

// The colours of the cells around a block of pixels, 0 or 1, as differences: the value of the first
// cell, steps to the next ones along u and along v, and mixed ones.
template <int kLines>
struct Window {
  HWY_INLINE Window() {}  // an implicit one is not compiled for the target

  V first;
  V u[kLines], v[kLines];
  V mixed[kLines][kLines];
};

template <int kLines>
HWY_INLINE void FindWindow(const float* bits, Window<kLines>* window) {
  const D d;
  const hn::RebindToSigned<D> di;
  const auto codes = hn::BitCast(di, hn::Load(d, bits));
  V cells[kLines + 1][kLines + 1];
  for (int q = 0; q <= kLines; ++q) {
    for (int p = 0; p <= kLines; ++p) {
      const auto bit = hn::Set(di, 1 << (q * (kLines + 1) + p));
      cells[p][q] = hn::IfThenElseZero(hn::RebindMask(d, hn::TestBit(codes, bit)), Const(1));
    }
  }
  window->first = cells[0][0];
  for (int p = 0; p < kLines; ++p) {
    window->u[p] = Sub(cells[p + 1][0], cells[p][0]);
    window->v[p] = Sub(cells[0][p + 1], cells[0][p]);
  }
  for (int p = 0; p < kLines; ++p) {
    for (int q = 0; q < kLines; ++q) {
      window->mixed[p][q] =
          Sub(Sub(cells[p + 1][q + 1], cells[p][q + 1]), Sub(cells[p + 1][q], cells[p][q]));
    }
  }
}

template <int kLines, int kOrder>
HWY_INLINE Coverage Cover(const float* bits, const View& view, int any_order,
                          const Lines<kLines>& lines) {
  const D d;
  const int order = kOrder == kAnyOrder ? any_order : kOrder;
  Window<kLines> window;
  FindWindow(bits, &window);
  Coverage c;
  c.value = window.first;
  V du[kLines], dv[kLines];
  c.uu = c.uv = c.vv = hn::Zero(d);
  V power = Const(1);
  for (int k = 0; k <= order; ++k) {
    const V first_scale = Mul(power, Const(kRoots[k + 1]));
    const V second_scale = Mul(first_scale, Const(kRoots[k + 2]));
    V across[kLines];  // sum over the lines along u
    for (int j = 0; j < kLines; ++j) {
      across[j] = k == 0 ? window.v[j] : hn::Zero(d);
    }
    if (k == 0) {
      for (int j = 0; j < kLines; ++j) c.value = MulThenAdd(across[j], lines.q[j][0], c.value);
    }
    V value = hn::Zero(d);
    for (int i = 0; i < kLines; ++i) {
      V along = k == 0 ? window.u[i] : hn::Zero(d);
      for (int j = 0; j < kLines; ++j) {
        const V m = window.mixed[i][j];
        along = MulThenAdd(m, lines.q[j][k], along);
        across[j] = MulThenAdd(m, lines.p[i][k], across[j]);
      }
      value = MulThenAdd(lines.p[i][k], along, value);
      const V slope = Mul(first_scale, Mul(lines.p[i][k + 1], along));
      du[i] = k == 0 ? slope : Add(du[i], slope);
      if (k <= kSecondOrder) {
        c.uu = MulThenAdd(second_scale, Mul(lines.p[i][k + 2], along), c.uu);
      }
    }
    for (int j = 0; j < kLines; ++j) {
      const V slope = Mul(first_scale, Mul(lines.q[j][k + 1], across[j]));
      dv[j] = k == 0 ? slope : Add(dv[j], slope);
      if (k <= kSecondOrder) {
        c.vv = MulThenAdd(second_scale, Mul(lines.q[j][k + 2], across[j]), c.vv);
      }
    }
    c.value = MulThenAdd(power, value, c.value);
    // d/du d/dv of order k is order k + 1 of the value.
    const V next = Mul(power, view.rho);
    if (k >= 1 && k <= kSecondOrder + 1) {
      const V before = k == 1 ? Const(1) : k == 2 ? view.rho : Mul(view.rho, view.rho);
      c.uv = MulThenAdd(Mul(before, Const(static_cast<float>(k))), value, c.uv);
    }
    power = next;
  }
  c.u = c.v = c.growth = hn::Zero(d);
  for (int i = 0; i < kLines; ++i) {
    const V gu = Mul(Mul(view.inverse_u, du[i]), lines.sign_u);
    const V gv = Mul(Mul(view.inverse_v, dv[i]), lines.sign_v);
    c.growth = i % 2 == 0 ? Sub(c.growth, Add(gu, gv)) : Add(c.growth, Add(gu, gv));
    c.u = Add(c.u, du[i]);
    c.v = Add(c.v, dv[i]);
  }
  c.u = Mul(c.u, view.inverse_u);
  c.v = Mul(c.v, view.inverse_v);
  c.uu = Mul(c.uu, Mul(view.inverse_u, view.inverse_u));
  c.vv = Mul(c.vv, Mul(view.inverse_v, view.inverse_v));
  c.uv = Mul(c.uv, Mul(view.inverse_u, view.inverse_v));
  return c;
}

// Columns of the equations of some blocks, which are added together: fewer loads and stores of the
// sums than one block after the other.
constexpr size_t kTogether = 4;
constexpr size_t kResidualRow = kPhotometricUnknowns;
constexpr size_t kWeightRow = kResidualRow + 1;

struct Equations {
  float rows[kTogether][kWeightRow + 1][kPixelLanes];
};

// Adds kTogether blocks' equations, of the first `unknowns` unknowns.
void AddEquations(const Equations& e, size_t unknowns, float huber, size_t lane, float* sums) {
  const D d;
  const V limit = Const(huber);
  const auto row = [&](size_t b, size_t i) HWY_ATTR { return hn::Load(d, e.rows[b][i] + lane); };
  V weight[kTogether], residual[kTogether];
  V cost = hn::Zero(d);
  for (size_t b = 0; b < kTogether; ++b) {
    residual[b] = row(b, kResidualRow);
    const V size = hn::Abs(residual[b]);
    const V plain = row(b, kWeightRow);
    weight[b] = Mul(plain, hn::Div(limit, hn::Max(size, limit)));
    // Huber's function: r^2, or limit (2 |r| - limit).
    const V small = hn::Min(size, limit);
    cost = Add(cost, Mul(plain, Mul(small, Sub(Add(size, size), small))));
  }
  const auto add = [&](size_t i, V value) HWY_ATTR {
    float* at = sums + i * kPixelLanes + lane;
    hn::Store(Add(hn::Load(d, at), value), d, at);
  };
  for (size_t i = 0; i < unknowns; ++i) {
    V weighted[kTogether];
    for (size_t b = 0; b < kTogether; ++b) weighted[b] = Mul(weight[b], row(b, i));
    float* at = sums + TriangleIndex(i, i) * kPixelLanes + lane;
    for (size_t j = i; j < unknowns; ++j, at += kPixelLanes) {
      const V upper = Add(Mul(weighted[0], row(0, j)), Mul(weighted[1], row(1, j)));
      const V lower = Add(Mul(weighted[2], row(2, j)), Mul(weighted[3], row(3, j)));
      hn::Store(Add(hn::Load(d, at), Add(upper, lower)), d, at);
    }
    const V upper = Add(Mul(weighted[0], residual[0]), Mul(weighted[1], residual[1]));
    const V lower = Add(Mul(weighted[2], residual[2]), Mul(weighted[3], residual[3]));
    add(kGradientSums + i, Add(upper, lower));
  }
  add(kCostSum, cost);
}

// Adds the nodes of a block of pixels: the pixel's own one, its hole, and the next one, where they
// are seen.
template <typename Shape>
HWY_NOINLINE void AddNodes(const float* nodes, const PixelBlocks& pixels, bool sees_hole,
                           const View& view, V growth, Coverage* coverage) {
  const D d;
  const auto field = [&](NodeField f) HWY_ATTR { return hn::Load(d, nodes + f * kPixelLanes); };
  const V body = Add(Const(1.5f), growth);
  const ShapePlace own{Sub(view.u, field(kOwnU)), Sub(view.v, field(kOwnV)), body};
  const ShapePlace next{Sub(view.u, field(kNextU)), Sub(view.v, field(kNextV)), body};
  if (pixels.lines == kFewLines) {
    AddLargeShape<Shape>(own, view, Const(1), coverage);
    if (pixels.sees_next) AddLargeShape<Shape>(next, view, field(kNextNode), coverage);
  } else {
    AddShape<Shape>(own, view, Const(1), 1, coverage);
    AddShape<Shape>(next, view, field(kNextNode), 1, coverage);
  }
  if (!sees_hole) return;
  const ShapePlace hole{own.du, own.dv, Sub(Const(0.5f), growth)};
  AddShape<Shape>(hole, view, hn::Neg(field(kOwnHole)), -1, coverage);
}

template <int kLines, int kOrder, bool kOuter>
void EvaluateBlock(const float* block, const PixelBlocks& pixels, bool sees_hole,
                   const PhotometricModel& m, size_t lane, float (*rows)[kPixelLanes],
                   float* residuals) {
  const D d;
  const float* fields = block + lane;
  const View view = LookAt(fields, pixels.has_lens, m);
  Lines<kLines> lines;
  FindLines<kLines, kOrder>(fields, view, Const(m.growth), pixels.order, &lines);
  Coverage k = Cover<kLines, kOrder>(fields + kPixelBlack * kPixelLanes, view, pixels.order, lines);
  const float* nodes = fields + kPixelFields * kPixelLanes;
  if (pixels.shape == InnerShape::kCircle) {
    AddNodes<Disc>(nodes, pixels, sees_hole, view, Const(m.growth), &k);
  } else if (pixels.shape == InnerShape::kHexagon) {
    AddNodes<Hexagon>(nodes, pixels, sees_hole, view, Const(m.growth), &k);
  }

  const V gain = MulThenAdd(Const(m.gain_y), view.v, MulThenAdd(Const(m.gain_x), view.u, Const(1)));
  const V contrast = Mul(gain, Const(m.black - m.white));
  V plain = MulThenAdd(Const(m.black - m.white), k.value, Const(m.white));
  V white_share = Sub(Const(1), k.value);
  V iu = Mul(contrast, k.u);
  V iv = Mul(contrast, k.v);
  V iuu = Mul(contrast, k.uu);
  V iuv = Mul(contrast, k.uv);
  V ivv = Mul(contrast, k.vv);
  V growth = Mul(contrast, k.growth);
  V level;
  V columns[kPhotometricUnknowns];
  if (kOuter) {
    const Coverage g =
        Cover<kLines, kOrder>(fields + kPixelBackground * kPixelLanes, view, pixels.order, lines);
    plain = Sub(plain, Mul(Const(m.white), g.value));
    white_share = Sub(white_share, g.value);
    const V step = Sub(Const(m.background), Mul(gain, Const(m.white)));
    iu = MulThenAdd(step, g.u, iu);
    iv = MulThenAdd(step, g.v, iv);
    iuu = MulThenAdd(step, g.uu, iuu);
    iuv = MulThenAdd(step, g.uv, iuv);
    ivv = MulThenAdd(step, g.vv, ivv);
    growth = MulThenAdd(step, g.growth, growth);
    level = MulThenAdd(gain, plain, Mul(Const(m.background), g.value));
    columns[kBackground] = g.value;
  } else {
    level = Mul(gain, plain);
  }
  const V residual = Sub(level, hn::Load(d, fields + kPixelLevel * kPixelLanes));
  const V depth = Add(Mul(iu, Sub(Const(m.normal[0]), Mul(view.u, Const(m.normal[2])))),
                      Mul(iv, Sub(Const(m.normal[1]), Mul(view.v, Const(m.normal[2])))));
  columns[kTauX] = hn::Neg(iu);
  columns[kTauY] = hn::Neg(iv);
  columns[kTauZ] = hn::Neg(depth);
  columns[kOmegaX] = hn::Neg(Mul(depth, view.v));
  columns[kOmegaY] = Mul(depth, view.u);
  columns[kOmegaZ] = Sub(Mul(iu, view.v), Mul(iv, view.u));
  columns[kBlack] = Mul(gain, k.value);
  columns[kWhite] = Mul(gain, white_share);
  columns[kGainX] = Mul(plain, view.u);
  columns[kGainY] = Mul(plain, view.v);
  const V half_uu = Mul(iuu, Const(0.5f));
  const V half_vv = Mul(ivv, Const(0.5f));
  const auto blur = [&](V ua, V va, V ub, V vb) HWY_ATTR {
    return Add(Add(Mul(half_uu, Mul(ua, ub)), Mul(half_vv, Mul(va, vb))),
               Mul(Mul(iuv, Const(0.5f)), Add(Mul(ua, vb), Mul(ub, va))));
  };
  columns[kBlurXx] = blur(view.ux, view.vx, view.ux, view.vx);
  columns[kBlurYy] = blur(view.uy, view.vy, view.uy, view.vy);
  const V xy = blur(view.ux, view.vx, view.uy, view.vy);
  columns[kBlurXy] = Add(xy, xy);
  columns[kGrowth] = growth;
  for (size_t i = 0; i < (kOuter ? kPhotometricUnknowns : kBackground); ++i) {
    hn::Store(columns[i], d, rows[i] + lane);
  }
  hn::Store(residual, d, rows[kResidualRow] + lane);
  hn::Store(hn::Load(d, fields + kPixelWeight * kPixelLanes), d, rows[kWeightRow] + lane);
  hn::Store(residual, d, residuals + lane);
}

template <int kLines, int kOrder, bool kOuter>
void EvaluateBlocks(const PixelBlocks& pixels, const PhotometricModel& model, int step, float* sums,
                    float* residuals) {
  const size_t lanes = hn::Lanes(D());
  const int first = kOuter ? pixels.inner_blocks : 0;
  const int end = kOuter ? pixels.blocks : pixels.inner_blocks;
  HWY_ALIGN Equations equations;
  for (int b = first; b < end;) {
    size_t together = 0;
    for (; together < kTogether && b < end; ++together, b += step) {
      const float* block = pixels.block(b);
      float* to = residuals + static_cast<size_t>(b) * kPixelLanes;
      for (size_t lane = 0; lane < kPixelLanes; lane += lanes) {
        EvaluateBlock<kLines, kOrder, kOuter>(block, pixels, b < pixels.hole_blocks, model, lane,
                                              equations.rows[together], to);
      }
    }
    for (; together < kTogether; ++together) {
      std::fill_n(&equations.rows[together][0][0], sizeof(equations.rows[0]) / sizeof(float), 0.0f);
    }
    const size_t unknowns = kOuter ? kPhotometricUnknowns : kBackground;
    for (size_t lane = 0; lane < kPixelLanes; lane += lanes) {
      AddEquations(equations, unknowns, model.huber, lane, sums);
    }
  }
}

template <int kLines, int kOrder>
void EvaluateAll(const PixelBlocks& pixels, const PhotometricModel& model, int step, float* sums,
                 float* residuals) {
  EvaluateBlocks<kLines, kOrder, false>(pixels, model, step, sums, residuals);
  EvaluateBlocks<kLines, kOrder, true>(pixels, model, step, sums, residuals);
}

void EvaluatePhotometric(const PixelBlocks& pixels, const PhotometricModel& model, int step,
                         PhotometricSums* sums, float* residuals) {
  HWY_ALIGN float lanes[kPhotometricSums * kPixelLanes] = {};
  if (pixels.lines == kManyLines) {
    EvaluateAll<kManyLines, kAnyOrder>(pixels, model, step, lanes, residuals);
  } else if (pixels.order == kLowOrder) {
    EvaluateAll<kFewLines, kLowOrder>(pixels, model, step, lanes, residuals);
  } else {
    EvaluateAll<kFewLines, kAnyOrder>(pixels, model, step, lanes, residuals);
  }
  for (size_t i = 0; i < kPhotometricSums; ++i) {
    double sum = 0;
    for (size_t k = 0; k < kPixelLanes; ++k) sum += static_cast<double>(lanes[i * kPixelLanes + k]);
    (*sums)[i] = sum;
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace topotag
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag {

HWY_EXPORT(EvaluatePhotometric);

void EvaluatePhotometric(const PixelBlocks& pixels, const PhotometricModel& model, int step,
                         PhotometricSums* sums, float* residuals) {
  HWY_DYNAMIC_DISPATCH(EvaluatePhotometric)(pixels, model, step, sums, residuals);
}

}  // namespace topotag
#endif  // HWY_ONCE
