// What a blurred pixel sees of a disc or a regular hexagon. Included once for each Highway target.

#if defined(TOPOTAG_HOST_PHOTOMETRIC_CHORD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TOPOTAG_HOST_PHOTOMETRIC_CHORD_INL_H_
#undef TOPOTAG_HOST_PHOTOMETRIC_CHORD_INL_H_
#else
#define TOPOTAG_HOST_PHOTOMETRIC_CHORD_INL_H_
#endif

#include "host/photometric_profile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace topotag {
namespace HWY_NAMESPACE {
namespace {

// A shape around the tag point (u, v) as seen from a pixel: half its width, and its growth's sign.
struct ShapePlace {
  V du, dv;  // pixel's tag point from the shape's centre
  V half;
};

// In the axes of the shape's nearest edge, the point spread function is a standard normal
// distribution: a step n across the edge is the tag vector n g, a step t along it t h.
struct EdgeAxes {
  HWY_INLINE EdgeAxes() {}  // an implicit one is not compiled for the target

  V mu, mv;  // the edge's unit normal
  V gu, gv, hu, hv;
  V area;            // gu hv - gv hu
  V bend_n, bend_t;  // growth of the widths along n and t
};

HWY_INLINE EdgeAxes MakeEdgeAxes(V mu, V mv, const View& view) {
  EdgeAxes axes;
  axes.mu = mu;
  axes.mv = mv;
  const V cu = Add(Mul(view.cuu, mu), Mul(view.cuv, mv));
  const V cv = Add(Mul(view.cuv, mu), Mul(view.cvv, mv));
  const V inverse = hn::Div(Const(1), hn::Sqrt(Add(Mul(cu, mu), Mul(cv, mv))));
  axes.gu = Mul(cu, inverse);
  axes.gv = Mul(cv, inverse);
  const V determinant = Sub(Mul(view.cuu, view.cvv), Mul(view.cuv, view.cuv));
  axes.area = hn::Sqrt(determinant);
  const V length = Mul(axes.area, inverse);
  axes.hu = hn::Neg(Mul(mv, length));
  axes.hv = Mul(mu, length);
  // Of the direction that a tag vector has in the image, along the change of scale there.
  const V per_u = Mul(Sub(Mul(view.cvv, view.bend_u), Mul(view.cuv, view.bend_v)),
                      hn::Div(Const(1), determinant));
  const V per_v = Mul(Sub(Mul(view.cuu, view.bend_v), Mul(view.cuv, view.bend_u)),
                      hn::Div(Const(1), determinant));
  axes.bend_n = Add(Mul(per_u, axes.gu), Mul(per_v, axes.gv));
  axes.bend_t = Add(Mul(per_u, axes.hu), Mul(per_v, axes.hv));
  return axes;
}

// Where the line of all n at one t enters and leaves the shape, and how that grows with it.
struct Chord {
  V enter, leave;
  V enter_growth, leave_growth;
};

struct Disc {
  // Places and weights of one half.
  static constexpr float kNormalRule[2][2] = {{0.741963784f, 0.454124145f},
                                              {2.33441422f, 0.0458758548f}};

  // The normal of the point of the circle that is nearest in widths of the point spread function.
  static HWY_INLINE EdgeAxes Axes(const ShapePlace& place, const View& view) {
    V mu = place.du, mv = place.dv;
    EdgeAxes axes;
    for (int i = 0; i < 3; ++i) {
      const V square = Add(Mul(mu, mu), Mul(mv, mv));
      const auto tiny = hn::Lt(square, Const(1e-8f));
      const V inverse = hn::Div(Const(1), hn::Sqrt(hn::Max(square, Const(1e-8f))));
      mu = hn::IfThenElse(tiny, Const(1), Mul(mu, inverse));
      mv = hn::IfThenElse(tiny, hn::Zero(D()), Mul(mv, inverse));
      axes = MakeEdgeAxes(mu, mv, view);
      if (i == 2) break;
      const Chord chord = At(place, axes, hn::Zero(D()));
      mu = MulThenAdd(chord.leave, axes.gu, place.du);
      mv = MulThenAdd(chord.leave, axes.gv, place.dv);
    }
    return axes;
  }
  // The range of t in which there are chords: its middle and half its length.
  static HWY_INLINE void Range(const ShapePlace& place, const EdgeAxes& axes, V* middle, V* half) {
    // The ellipse's tangents along n: the points whose normal is perpendicular to g.
    const V inverse = hn::Div(Const(1), axes.area);
    const V g = hn::Sqrt(Add(Mul(axes.gu, axes.gu), Mul(axes.gv, axes.gv)));
    *middle = Mul(Sub(Mul(place.du, axes.gv), Mul(place.dv, axes.gu)), inverse);
    *half = Mul(Mul(place.half, g), inverse);
  }
  static HWY_INLINE Chord At(const ShapePlace& place, const EdgeAxes& axes, V t) {
    const V x = MulThenAdd(t, axes.hu, place.du), y = MulThenAdd(t, axes.hv, place.dv);
    const V a = Add(Mul(axes.gu, axes.gu), Mul(axes.gv, axes.gv));
    const V b = Add(Mul(axes.gu, x), Mul(axes.gv, y));
    const V c = Sub(Add(Mul(x, x), Mul(y, y)), Mul(place.half, place.half));
    const V square = Sub(Mul(b, b), Mul(a, c));
    const V root = hn::Sqrt(hn::Max(square, hn::Zero(D())));
    const V inverse = hn::Div(Const(1), a);
    // Bounded where the line touches the circle, none where it misses it.
    const V least = Mul(Mul(Const(0.1f), place.half), hn::Sqrt(a));
    const V growth = hn::IfThenElseZero(hn::Gt(square, hn::Zero(D())),
                                        hn::Div(place.half, hn::Max(root, least)));
    return {Mul(hn::Neg(Add(root, b)), inverse), Mul(Sub(root, b), inverse), hn::Neg(growth),
            growth};
  }
};

// With two sides across v.
struct Hexagon {
  static constexpr float kNormalRule[3][2] = {
      {0.61670659f, 0.40882847f}, {1.88917588f, 0.088615746f}, {3.32425743f, 0.0025557844f}};
  static constexpr float kNormals[3][2] = {{0, 1}, {0.866025404f, 0.5f}, {0.866025404f, -0.5f}};

  static HWY_INLINE EdgeAxes Axes(const ShapePlace& place, const View& view) {
    V best = Const(-1e9f), mu = Const(0), mv = Const(1);
    for (const auto& normal : kNormals) {
      const V along = Add(Mul(place.du, Const(normal[0])), Mul(place.dv, Const(normal[1])));
      const V variance = Add(Add(Mul(view.cuu, Const(normal[0] * normal[0])),
                                 Mul(view.cuv, Const(2 * normal[0] * normal[1]))),
                             Mul(view.cvv, Const(normal[1] * normal[1])));
      const V distance = hn::Div(Sub(hn::Abs(along), place.half), hn::Sqrt(variance));
      const auto nearer = hn::Gt(distance, best);
      const V sign = hn::IfThenElse(hn::Lt(along, hn::Zero(D())), Const(-1), Const(1));
      best = hn::IfThenElse(nearer, distance, best);
      mu = hn::IfThenElse(nearer, Mul(sign, Const(normal[0])), mu);
      mv = hn::IfThenElse(nearer, Mul(sign, Const(normal[1])), mv);
    }
    return MakeEdgeAxes(mu, mv, view);
  }
  static HWY_INLINE void Range(const ShapePlace& place, const EdgeAxes& axes, V* middle, V* half) {
    const V inverse = hn::Div(Const(1), axes.area);
    *middle = Mul(Sub(Mul(place.du, axes.gv), Mul(place.dv, axes.gu)), inverse);
    V most = hn::Zero(D());
    constexpr float kCorners[3][2] = {{1.15470054f, 0}, {0.577350269f, 1}, {0.577350269f, -1}};
    for (const auto& corner : kCorners) {
      most = hn::Max(most,
                     hn::Abs(Sub(Mul(axes.gv, Const(corner[0])), Mul(axes.gu, Const(corner[1])))));
    }
    *half = Mul(Mul(most, place.half), inverse);
  }
  static HWY_INLINE Chord At(const ShapePlace& place, const EdgeAxes& axes, V t) {
    const V x = MulThenAdd(t, axes.hu, place.du), y = MulThenAdd(t, axes.hv, place.dv);
    Chord chord{Const(-1e4f), Const(1e4f), hn::Zero(D()), hn::Zero(D())};
    for (const auto& normal : kNormals) {
      const V along = Add(Mul(x, Const(normal[0])), Mul(y, Const(normal[1])));
      const V slope = Add(Mul(axes.gu, Const(normal[0])), Mul(axes.gv, Const(normal[1])));
      const V size = hn::Max(hn::Abs(slope), Const(1e-5f));
      const V inverse = hn::Div(Const(1), size);
      const V signed_along = hn::IfThenElse(hn::Lt(slope, hn::Zero(D())), hn::Neg(along), along);
      const V leave = Mul(Sub(place.half, signed_along), inverse);
      const V enter = hn::Neg(Mul(Add(place.half, signed_along), inverse));
      const auto first = hn::Lt(leave, chord.leave);
      chord.leave = hn::IfThenElse(first, leave, chord.leave);
      chord.leave_growth = hn::IfThenElse(first, inverse, chord.leave_growth);
      const auto last = hn::Gt(enter, chord.enter);
      chord.enter = hn::IfThenElse(last, enter, chord.enter);
      chord.enter_growth = hn::IfThenElse(last, hn::Neg(inverse), chord.enter_growth);
    }
    const V middle = Mul(Add(chord.enter, chord.leave), Const(0.5f));
    const auto empty = hn::Lt(chord.leave, chord.enter);
    chord.enter = hn::IfThenElse(empty, middle, chord.enter);
    chord.leave = hn::IfThenElse(empty, middle, chord.leave);
    chord.enter_growth = hn::IfThenElse(empty, hn::Zero(D()), chord.enter_growth);
    chord.leave_growth = hn::IfThenElse(empty, hn::Zero(D()), chord.leave_growth);
    return chord;
  }
};

// Chebyshev's second rule over the range of t, for functions that end like square roots.
constexpr int kChords = 8;
constexpr float kChordPlace[kChords] = {-0.93969262f, -0.76604444f, -0.5f,       -0.17364818f,
                                        0.17364818f,  0.5f,         0.76604444f, 0.93969262f};
constexpr float kChordWeight[kChords] = {0.11938755f, 0.22437319f, 0.30229989f, 0.34376075f,
                                         0.34376075f, 0.30229989f, 0.22437319f, 0.11938755f};
constexpr float kFarthestChord = 3.6f;  // widths of the point spread function

// What a pixel sees of a shape, and its derivatives by the place of the shape's edge across it and
// along it, and by the shape's width.
struct Seen {
  V value, n, t, nn, nt, tt, growth;
};

HWY_INLINE void AddInTagAxes(const EdgeAxes& axes, const Seen& seen, V sign, float growth_sign,
                             Coverage* coverage) {
  const V value = seen.value, n = seen.n, t = seen.t, nn = seen.nn, nt = seen.nt, tt = seen.tt;
  const V inverse = hn::Div(sign, axes.area);
  const V inverse2 = hn::Div(inverse, axes.area);
  coverage->value = MulThenAdd(sign, value, coverage->value);
  coverage->u = Add(coverage->u, Mul(inverse, Sub(Mul(n, axes.hv), Mul(t, axes.gv))));
  coverage->v = Add(coverage->v, Mul(inverse, Sub(Mul(t, axes.gu), Mul(n, axes.hu))));
  const auto second = [&](V pa, V qa, V pb, V qb) HWY_ATTR {
    return Mul(inverse2, Add(Add(Mul(nn, Mul(pa, pb)), Mul(tt, Mul(qa, qb))),
                             Mul(nt, Add(Mul(pa, qb), Mul(pb, qa)))));
  };
  const V pu = axes.hv, pv = hn::Neg(axes.hu), qu = hn::Neg(axes.gv), qv = axes.gu;
  coverage->uu = Add(coverage->uu, second(pu, qu, pu, qu));
  coverage->uv = Add(coverage->uv, second(pu, qu, pv, qv));
  coverage->vv = Add(coverage->vv, second(pv, qv, pv, qv));
  coverage->growth = Add(coverage->growth, Mul(Mul(sign, Const(growth_sign)), seen.growth));
}

// Adds `sign` times what a pixel sees of a shape. `growth_sign` is that of the shape's own growth.
template <typename Shape>
HWY_NOINLINE void AddShape(const ShapePlace& place, const View& view, V sign, float growth_sign,
                           Coverage* coverage) {
  const EdgeAxes axes = Shape::Axes(place, view);
  V middle, half;
  Shape::Range(place, axes, &middle, &half);
  const V first = hn::Max(Sub(middle, half), Const(-kFarthestChord));
  const V last = hn::Max(hn::Min(Add(middle, half), Const(kFarthestChord)), first);
  middle = Mul(Add(first, last), Const(0.5f));
  half = Mul(Sub(last, first), Const(0.5f));
  V value = hn::Zero(D()), n = value, t = value, nn = value, nt = value, tt = value, r = value;
  for (int k = 0; k < kChords; ++k) {
    const V at = MulThenAdd(half, Const(kChordPlace[k]), middle);
    Chord chord = Shape::At(place, axes, at);
    const V tilt = MulThenAdd(at, axes.bend_t, Const(1));
    chord.leave = Mul(chord.leave, MulThenAdd(chord.leave, axes.bend_n, tilt));
    chord.enter = Mul(chord.enter, MulThenAdd(chord.enter, axes.bend_n, tilt));
    V leave[2], enter[2];
    Profile(chord.leave, 2, leave);
    Profile(chord.enter, 2, enter);
    const V weight = Mul(Mul(half, Const(kChordWeight[k])),
                         Mul(Const(0.39894228f), ExpOfMinus(Mul(Const(0.5f), Mul(at, at)))));
    const V inside = Mul(weight, Sub(leave[0], enter[0]));
    const V slope = Mul(weight, Sub(leave[1], enter[1]));
    value = Add(value, inside);
    n = Sub(n, slope);
    nn = Sub(nn, Mul(weight, Sub(Mul(chord.leave, leave[1]), Mul(chord.enter, enter[1]))));
    t = MulThenAdd(at, inside, t);
    nt = Sub(nt, Mul(at, slope));
    tt = MulThenAdd(Sub(Mul(at, at), Const(1)), inside, tt);
    r = Add(r,
            Mul(weight, Sub(Mul(leave[1], chord.leave_growth), Mul(enter[1], chord.enter_growth))));
  }
  AddInTagAxes(axes, {value, n, t, nn, nt, tt, r}, sign, growth_sign, coverage);
}

// Gauss and Hermite's rule for the mean over a standard normal t: of a shape so large that the
// other end of its chords is not seen.
template <typename Shape>
HWY_NOINLINE void AddLargeShape(const ShapePlace& place, const View& view, V sign,
                                Coverage* coverage) {
  const EdgeAxes axes = Shape::Axes(place, view);
  V value = hn::Zero(D()), n = value, t = value, nn = value, nt = value, tt = value, r = value;
  for (const auto& node : Shape::kNormalRule) {
    for (const float side : {node[0], -node[0]}) {
      const V at = Const(side), weight = Const(node[1]);
      Chord chord = Shape::At(place, axes, at);
      const V tilt = MulThenAdd(at, axes.bend_t, Const(1));
      chord.leave = Mul(chord.leave, MulThenAdd(chord.leave, axes.bend_n, tilt));
      chord.enter = Mul(chord.enter, MulThenAdd(chord.enter, axes.bend_n, tilt));
      V leave[2], enter[2];
      Profile(chord.leave, 2, leave);
      Profile(chord.enter, 2, enter);
      const V inside = Mul(weight, Sub(leave[0], enter[0]));
      const V slope = Mul(weight, Sub(leave[1], enter[1]));
      value = Add(value, inside);
      n = Sub(n, slope);
      nn = Sub(nn, Mul(weight, Sub(Mul(chord.leave, leave[1]), Mul(chord.enter, enter[1]))));
      t = MulThenAdd(at, inside, t);
      nt = Sub(nt, Mul(at, slope));
      tt = MulThenAdd(Const(side * side - 1), inside, tt);
      r = Add(r, Mul(weight,
                     Sub(Mul(leave[1], chord.leave_growth), Mul(enter[1], chord.enter_growth))));
    }
  }
  AddInTagAxes(axes, {value, n, t, nn, nt, tt, r}, sign, 1, coverage);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace topotag
HWY_AFTER_NAMESPACE();

#endif  // per target
