#include "host/photometric_scan.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "host/photometric_scan.cc"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>

#include "host/photometric_profile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace topotag {
namespace HWY_NAMESPACE {
namespace {

using DI = hn::RebindToSigned<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;

struct Nodes {
  HWY_INLINE Nodes() {}  // an implicit one is not compiled for the target

  V u, v;  // centre
  V has_hole;
};

// The nodes whose cells tag points lie in; of the baseline node, the nearer of its two shapes.
HWY_INLINE Nodes OwnNodes(V u, V v, int n, const float* holes) {
  const DI di;
  const V first = Const(-2.0f * static_cast<float>(n - 1));
  const V last = Const(static_cast<float>(n - 1));
  const auto cell = [&](V x) HWY_ATTR {
    return hn::Min(hn::Max(hn::Round(Mul(Sub(x, first), Const(0.25f))), hn::Zero(D())), last);
  };
  const V column = cell(u), row = cell(v);
  const auto index =
      hn::Add(hn::Mul(hn::ConvertTo(di, row), hn::Set(di, n)), hn::ConvertTo(di, column));
  const M baseline = hn::And(hn::Eq(row, hn::Zero(D())), hn::Le(column, Const(1)));
  const V shape = hn::IfThenElse(hn::Lt(u, Add(first, Const(1))), first, Add(first, Const(2)));
  Nodes nodes;
  nodes.u = hn::IfThenElse(baseline, shape, MulThenAdd(column, Const(4), first));
  nodes.v = MulThenAdd(row, Const(4), first);
  nodes.has_hole = hn::IfThenElse(baseline, Const(1), hn::GatherIndex(D(), holes, index));
  return nodes;
}

// Whether points lie near the edges of their own nodes or of the nodes' holes, whose widths are 3
// and 1 across the edge that faces the point; false where the two shapes of the baseline node meet.
HWY_INLINE M NearNodes(const ScanRule& rule, V u, V v, V cuu, V cuv, V cvv, M* between,
                       M* sees_hole) {
  const Nodes node = OwnNodes(u, v, rule.n, rule.cells->holes.data());
  const V du = Sub(u, node.u), dv = Sub(v, node.v);
  // Squared distance times a squared length, and the normal of that length.
  V mu = du, mv = dv, distance, length;
  if (rule.shape == InnerShape::kCircle) {
    length = Add(Mul(du, du), Mul(dv, dv));
    distance = hn::Sqrt(length);
  } else {
    mu = hn::Zero(D());
    mv = length = Const(1);
    distance = hn::Abs(dv);
    for (const float sign : {0.5f, -0.5f}) {
      const V across = hn::Abs(Add(Mul(du, Const(0.866025404f)), Mul(dv, Const(sign))));
      const M nearer = hn::Gt(across, distance);
      distance = hn::IfThenElse(nearer, across, distance);
      mu = hn::IfThenElse(nearer, Const(0.866025404f), mu);
      mv = hn::IfThenElse(nearer, Const(sign), mv);
    }
  }
  const V variance =
      Add(Add(Mul(Mul(mu, mu), cuu), Mul(Mul(Add(mu, mu), mv), cuv)), Mul(Mul(mv, mv), cvv));
  const V limit = Mul(variance, Const(rule.near_square));
  const auto is_near = [&](float half) HWY_ATTR {
    const V off = Sub(distance, Const(half));
    return hn::Le(Mul(Mul(off, off), length), limit);
  };
  const float first = -2.0f * static_cast<float>(rule.n - 1);
  const V margin = MulThenAdd(hn::Sqrt(cuu), Const(1.5f), Const(0.5f));
  *between = hn::And(hn::Lt(hn::Abs(Sub(u, Const(first + 1))), margin),
                     hn::Lt(hn::Abs(Sub(v, Const(first))), Const(2)));
  const M has_hole = hn::Gt(node.has_hole, hn::Zero(D()));
  const V off = hn::Max(Sub(distance, Const(0.5f)), hn::Zero(D()));
  *sees_hole =
      hn::And(has_hole, hn::Le(Mul(Mul(off, off), length), Mul(variance, Const(rule.seen_square))));
  return hn::Or(is_near(1.5f), hn::And(is_near(0.5f), has_hole));
}

// Where a list goes on.
struct PixelEnd {
  explicit PixelEnd(PixelList& list)
      : places(list.places.data()),
        cells(list.cells.data()),
        count(static_cast<size_t>(list.count)) {}
  int32_t* HWY_RESTRICT places;
  int32_t* HWY_RESTRICT cells;
  size_t count;
};

void ScanRun(const ScanRule& rule_in, const PixelRun& run_in, PixelLists* lists) {
  // Copies, which the lists' pixels cannot alias.
  const ScanRule rule = rule_in;
  const PixelRun run = run_in;
  const D d;
  const DI di;
  const auto lanes = static_cast<int>(hn::Lanes(d));
  const auto start = [&](const std::array<float, 3>& r) {
    return static_cast<float>(static_cast<double>(r[0]) + static_cast<double>(r[1]) * run.first_x +
                              static_cast<double>(r[2]) * run.first_y);
  };
  const auto step = [&](const std::array<float, 3>& r) {
    return static_cast<float>(static_cast<double>(r[1]) * run.step_x +
                              static_cast<double>(r[2]) * run.step_y);
  };
  const V u0 = Const(start(rule.u)), v0 = Const(start(rule.v)), w0 = Const(start(rule.w));
  const V u1 = Const(step(rule.u)), v1 = Const(step(rule.v)), w1 = Const(step(rule.w));
  const V limit = Const(rule.limit), half = Const(0.5f);
  const V middle = Const(static_cast<float>(UnitPattern::kHalf) + 0.5f);
  const V near = Const(rule.near_square);
  // Derivatives of the tag point along the run, and across it, which here is along y, times w^2:
  // the former do not change along the run.
  const float w_start = start(rule.w), w_step = step(rule.w);
  const auto along = [&](const std::array<float, 3>& r) {
    return step(r) * w_start - start(r) * w_step;
  };
  const V ux = Const(along(rule.u)), vx = Const(along(rule.v));
  const V ux2 = Mul(ux, ux), vx2 = Mul(vx, vx), uxvx = Mul(ux, vx);
  const auto across = [&](const std::array<float, 3>& r, V* first, V* change) HWY_ATTR {
    *first = Const(r[2] * w_start - start(r) * rule.w[2]);
    *change = Const(r[2] * w_step - step(r) * rule.w[2]);
  };
  V uy0, uy1, vy0, vy1;
  across(rule.u, &uy0, &uy1);
  across(rule.v, &vy0, &vy1);
  const bool is_round = rule.shape != InnerShape::kSquare;
  PixelEnd holes(lists->holes), inner(lists->inner), outer(lists->outer);
  for (int k = 0; k < run.count; k += lanes) {
    const V at = hn::ConvertTo(d, hn::Iota(di, k));
    const V scale = hn::Div(Const(1), MulThenAdd(at, w1, w0));
    const V u = Mul(MulThenAdd(at, u1, u0), scale), v = Mul(MulThenAdd(at, v1, v0), scale);
    const M inside = hn::And(hn::Lt(at, Const(static_cast<float>(run.count))),
                             hn::And(hn::Lt(hn::Abs(u), limit), hn::Lt(hn::Abs(v), limit)));
    const V pu = Add(hn::IfThenElseZero(inside, u), middle);
    const V pv = Add(hn::IfThenElseZero(inside, v), middle);
    const VI column = hn::ConvertTo(di, pu), line = hn::ConvertTo(di, pv);
    const VI cell = hn::Add(hn::ShiftLeft<6>(line), column);
    const VI flags = hn::GatherIndex(di, rule.cells->flags.data(), cell);
    // The point spread function on the tag.
    const V square = Mul(scale, scale);
    const V uy = MulThenAdd(at, uy1, uy0), vy = MulThenAdd(at, vy1, vy0);
    const V variance = Mul(Const(rule.blur), Mul(square, square));
    const V cuu = Mul(variance, MulThenAdd(uy, uy, ux2)),
            cvv = Mul(variance, MulThenAdd(vy, vy, vx2));
    // The sides of the cell that the pixel is near to.
    const auto sides = [&](V place, VI whole, V variance, CellFlag before,
                           CellFlag after) HWY_ATTR {
      const V f = Sub(Sub(place, hn::ConvertTo(d, whole)), half);
      const V rest = Sub(half, hn::Abs(f));
      const auto is_near = hn::RebindMask(di, hn::Lt(Mul(rest, rest), Mul(near, variance)));
      const auto is_before = hn::RebindMask(di, hn::Lt(f, hn::Zero(d)));
      return hn::IfThenElseZero(is_near,
                                hn::IfThenElse(is_before, hn::Set(di, before), hn::Set(di, after)));
    };
    const VI wanted = hn::Or(sides(pu, column, cuu, kEdgeLeft, kEdgeRight),
                             sides(pv, line, cvv, kEdgeAbove, kEdgeBelow));
    M chosen = hn::RebindMask(d, hn::Ne(hn::And(flags, wanted), hn::Zero(di)));
    M sees_hole = hn::Lt(at, hn::Zero(d));
    if (is_round) {
      const V cuv = Mul(variance, MulThenAdd(uy, vy, uxvx));
      M between;
      const M near_node = NearNodes(rule, u, v, cuu, cuv, cvv, &between, &sees_hole);
      const M used = hn::RebindMask(d, hn::Eq(hn::And(flags, hn::Set(di, kNotUsed)), hn::Zero(di)));
      chosen = hn::AndNot(between, hn::Or(chosen, hn::And(near_node, used)));
    }
    if (rule.clear_square > 0) {
      // What is not known must not reach the pixel.
      const auto is_clear = [&](V place, V variance) HWY_ATTR {
        const V rest = Sub(limit, hn::Abs(place));
        return hn::Ge(Mul(rest, rest), Mul(Const(rule.clear_square), variance));
      };
      chosen = hn::And(chosen, hn::And(is_clear(u, cuu), is_clear(v, cvv)));
    }
    chosen = hn::And(chosen, inside);
    const VI places = hn::Iota(di, (run.y << 16) + run.x + k);
    const M sees =
        hn::RebindMask(d, hn::Ne(hn::And(flags, hn::Set(di, kSeesBackground)), hn::Zero(di)));
    const auto append = [&](M mask, PixelEnd* end) HWY_ATTR {
      const auto selected = hn::RebindMask(di, mask);
      hn::StoreU(hn::Compress(cell, selected), di, end->cells + end->count);
      hn::StoreU(hn::Compress(places, selected), di, end->places + end->count);
      end->count += hn::CountTrue(di, selected);
    };
    if (hn::AllFalse(d, chosen)) continue;
    const M sees_both = hn::And(sees, chosen);
    if (!hn::AllFalse(d, sees_both)) {
      append(sees_both, &outer);
      chosen = hn::AndNot(sees, chosen);
    }
    if (is_round) {
      append(hn::And(sees_hole, chosen), &holes);
      chosen = hn::AndNot(sees_hole, chosen);
    }
    append(chosen, &inner);
  }
  lists->holes.count = static_cast<int>(holes.count);
  lists->inner.count = static_cast<int>(inner.count);
  lists->outer.count = static_cast<int>(outer.count);
}

// The pixels' own nodes, and those beyond the gap that are nearest to them.
HWY_INLINE void PackNodes(const ScanRule& rule, V u, V v, size_t stride, float* to) {
  const D d;
  const auto set = [&](NodeField f, V value)
                       HWY_ATTR { hn::Store(value, d, to + static_cast<size_t>(f) * stride); };
  const float* holes = rule.cells->holes.data();
  const Nodes own = OwnNodes(u, v, rule.n, holes);
  const V du = Sub(u, own.u), dv = Sub(v, own.v);
  const M along_u = hn::Gt(hn::Abs(du), hn::Abs(dv));
  // Far enough to be in the next cell, from either shape of the baseline node, too.
  const V far_u = Add(own.u, hn::IfThenElseZero(along_u, hn::CopySign(Const(4.5f), du)));
  const V far_v = Add(own.v, hn::IfThenZeroElse(along_u, hn::CopySign(Const(4), dv)));
  const V limit = Const(2.0f * static_cast<float>(rule.n));
  const Nodes next = OwnNodes(far_u, far_v, rule.n, holes);
  const M within = hn::And(hn::Le(hn::Abs(far_u), limit), hn::Le(hn::Abs(far_v), limit));
  const M same = hn::And(hn::Eq(next.v, own.v), hn::Lt(hn::Abs(Sub(next.u, own.u)), Const(3)));
  set(kOwnU, own.u);
  set(kOwnV, own.v);
  set(kOwnHole, own.has_hole);
  set(kNextU, next.u);
  set(kNextV, next.v);
  set(kNextNode, hn::IfThenElseZero(hn::AndNot(same, within), Const(1)));
}

void PackPixels(const ScanRule& rule, int center_x, int center_y, PixelList* list, size_t stride,
                float* blocks) {
  const D d;
  const DI di;
  const size_t lanes = hn::Lanes(d);
  const auto count = static_cast<size_t>(list->count);
  const size_t end = (count + kPixelLanes - 1) / kPixelLanes * kPixelLanes;
  for (size_t k = count; k < end; ++k) {
    list->places[k] = list->places[count - 1];
    list->cells[k] = list->cells[count - 1];
  }
  for (size_t k = 0; k < end; k += lanes) {
    float* to = blocks + k / kPixelLanes * stride + k % kPixelLanes;
    const VI place = hn::Load(di, list->places.data() + k);
    const VI cell = hn::Load(di, list->cells.data() + k);
    const V x =
        hn::ConvertTo(d, hn::Sub(hn::And(place, hn::Set(di, 0xFFFF)), hn::Set(di, center_x)));
    const V y = hn::ConvertTo(d, hn::Sub(hn::ShiftRight<16>(place), hn::Set(di, center_y)));
    const auto set = [&](PixelField f, V value) HWY_ATTR {
      hn::Store(value, d, to + static_cast<size_t>(f) * kPixelLanes);
    };
    const V index = hn::ConvertTo(d, hn::Iota(di, static_cast<int>(k)));
    set(kPixelX, x);
    set(kPixelY, y);
    set(kPixelWeight,
        hn::IfThenElseZero(hn::Lt(index, Const(static_cast<float>(count))), Const(1)));
    const VI half = hn::Set(di, UnitPattern::kHalf);
    set(kPixelU,
        hn::ConvertTo(d, hn::Sub(hn::And(cell, hn::Set(di, PhotometricCells::kStride - 1)), half)));
    set(kPixelV, hn::ConvertTo(d, hn::Sub(hn::ShiftRight<6>(cell), half)));
    const auto look_up = [&](const PhotometricCells::Table& table) HWY_ATTR {
      return hn::BitCast(d, hn::GatherIndex(di, table.data(), cell));
    };
    set(kPixelFlags, look_up(rule.cells->flags));
    set(kPixelBlack, look_up(rule.cells->black));
    set(kPixelBackground, look_up(rule.cells->background));
  }
}

void PackNodeFields(const ScanRule& rule, size_t count, size_t stride, float* blocks) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  for (size_t k = 0; k < count; k += lanes) {
    float* to = blocks + k / kPixelLanes * stride + k % kPixelLanes;
    const V x = hn::Load(d, to + kPixelX * kPixelLanes);
    const V y = hn::Load(d, to + kPixelY * kPixelLanes);
    const auto row = [&](const std::array<float, 3>& r) HWY_ATTR {
      return MulThenAdd(y, Const(r[2]), MulThenAdd(x, Const(r[1]), Const(r[0])));
    };
    const V scale = hn::Div(Const(1), row(rule.w));
    PackNodes(rule, Mul(row(rule.u), scale), Mul(row(rule.v), scale), kPixelLanes,
              to + kPixelFields * kPixelLanes);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace topotag
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag {

HWY_EXPORT(ScanRun);
HWY_EXPORT(PackPixels);
HWY_EXPORT(PackNodeFields);

void ScanRun(const ScanRule& rule, const PixelRun& run, PixelLists* lists) {
  HWY_DYNAMIC_DISPATCH(ScanRun)(rule, run, lists);
}

void PackPixels(const ScanRule& rule, int center_x, int center_y, PixelList* list, size_t stride,
                float* blocks) {
  HWY_DYNAMIC_DISPATCH(PackPixels)(rule, center_x, center_y, list, stride, blocks);
}

void PackNodeFields(const ScanRule& rule, size_t count, size_t stride, float* blocks) {
  HWY_DYNAMIC_DISPATCH(PackNodeFields)(rule, count, stride, blocks);
}

}  // namespace topotag
#endif  // HWY_ONCE
