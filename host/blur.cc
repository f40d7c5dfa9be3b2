#include "host/blur.h"

#include <algorithm>
#include <cmath>

namespace topotag {
namespace {

constexpr double kPixelVariance = 1.0 / 12;
// Of bilinear interpolation, over all phases.
constexpr double kInterpolationVariance = 1.0 / 6;
// Range of the blur that is looked for: pixels; units.
constexpr double kMinSigma = 0.45;
constexpr double kMaxWidth = 0.7;
constexpr int kHalvings = 5;

// By z.
constexpr double kTableStart = 0.5;
constexpr double kTableStep = 0.125;
constexpr int kTableSize = 31;
constexpr double kTail[kTableSize] = {
    0.3085,    0.266,     0.2266,    0.1908,    0.1587,    0.1303,    0.1056,   0.08457,
    0.06681,   0.05208,   0.04006,   0.0304,    0.02275,   0.01679,   0.01222,  0.008774,
    0.00621,   0.004332,  0.00298,   0.00202,   0.00135,   0.000889,  0.000577, 0.0003691,
    0.0002326, 0.0001445, 8.842e-05, 5.331e-05, 3.167e-05, 1.854e-05, 0};
constexpr double kTailIntegral[kTableSize] = {
    0.1978,    0.1619,    0.1312,    0.1051,    0.08332,   0.0653,    0.05059,   0.03873,
    0.02931,   0.02191,   0.01617,   0.01179,   0.008491,  0.006035,  0.004235,  0.002933,
    0.002004,  0.001352,  0.0008992, 0.0005902, 0.0003822, 0.0002441, 0.0001537, 9.548e-05,
    5.848e-05, 3.532e-05, 2.103e-05, 1.235e-05, 7.145e-06, 4.076e-06, 0};

// A place in the tables.
struct Place {
  explicit Place(double z) {
    const double at = (z - kTableStart) / kTableStep;
    const double within = std::min(std::max(at, 0.0), kTableSize - 1.001);
    i = static_cast<int>(within);
    part = within - i;
  }
  double In(const double* table) const { return table[i] + part * (table[i + 1] - table[i]); }

  int i;
  double part;
};

double Mix(double circle, double square, double squareness) {
  return circle + squareness * (square - circle);
}

// Pixels that a unit spans across: between its sides; in the directions of the greatest and the
// least foreshortening, and halfway; between its sides, in proportion, if it had no shear and the
// same area.
struct Heights {
  double u, v;
  double least, most, middle;
  double upright_u, upright_v;
};

Heights DirectionsOf(const UnitHeights& h) {
  // The squares of what a pixel spans in perpendicular directions add up to the same in all.
  const double mean = 0.5 / (h.u * h.u) + 0.5 / (h.v * h.v);
  const double spread = std::sqrt(std::max(mean * mean - 1 / (h.area * h.area), 0.0));
  const double shear = std::sqrt(std::max(h.area / (h.u * h.v), 1.0));
  return {h.u,
          h.v,
          1 / std::sqrt(mean + spread),
          1 / std::sqrt(std::max(mean - spread, 0.25 * mean)),
          1 / std::sqrt(mean),
          h.u * shear,
          h.v * shear};
}

struct Response {
  double dark_gap;    // what gaps lack of white, of the contrast of black and white
  double gap;         // over what is taken for black, of the same
  double holes;       // over the same black, in parts of the gaps
  double squareness;  // of nodes whose corners look as measured
};

// What passes through a disc, but for exp(-z^2 / 2) of it, z being its radius in widths of the
// blur.
double BesideDisc(double z) {
  constexpr double kPeak = 2.5066282746310002;  // sqrt(2 pi)
  const Place place(z);
  return kPeak * (place.In(kTailIntegral) + z * place.In(kTail));
}

// What is seen of holes and gaps of 1 unit. The numbers in it are fitted to integrals over blurred
// discs and squares.
// @param scale   1 / 2 sigma of the blur, pixels^-1
// @param corner  darkness beside that of gaps, in parts of the gaps over black
Response ResponseTo(double scale, const Heights& height, double corner, bool solid) {
  const double lost = NormalTail(scale * height.u) + NormalTail(scale * height.v);
  const double beside =
      0.25 * (BesideDisc(scale * height.least) + BesideDisc(scale * height.most)) +
      0.5 * BesideDisc(scale * height.middle);
  const double square_hole = (1 - 2 * NormalTail(scale * height.upright_u)) *
                             (1 - 2 * NormalTail(scale * height.upright_v));
  struct Look {
    double hole, gap, black, corner;
  };
  const Look disc{1 - beside, 1 - 0.37 * lost, solid ? 0 : 0.074 + 0.92 * lost, 1 - 0.2 * lost};
  const Look square{square_hole, 1 - 0.78 * lost, solid ? 0 : 0.8 * lost, 0.75};
  const auto excess = [&](const Look& look) {
    return look.gap - look.corner - corner * (look.gap - look.black);
  };
  const double of_disc = excess(disc);
  // Corners tell less the more blur there is, and nothing in the end.
  const double apart = std::min(of_disc - excess(square), -0.02);
  const double t = std::clamp(of_disc / apart, 0.0, 1.0);
  const double black = Mix(disc.black, square.black, t);
  const double gap = Mix(disc.gap, square.gap, t);
  return {1 - gap, gap - black, (Mix(disc.hole, square.hole, t) - black) / (gap - black), t};
}

}  // namespace

double NormalTail(double z) { return Place(z).In(kTail); }

double NormalTailIntegral(double z) { return Place(z).In(kTailIntegral); }

Blur FindBlur(const BlurredLevels& levels, const UnitHeights& unit) {
  const Heights height = DirectionsOf(unit);
  const double range = levels.gap - levels.black;
  const double holes = (levels.hole - levels.black) / range;
  const double corner = (levels.gap - levels.corner) / range;
  double low = 0.5 / kMaxWidth / std::min(height.u, height.v);
  double high = 0.5 / kMinSigma;
  double below = -holes;  // of what is seen at `low` beside what is measured
  double above = 1 - holes;
  for (int i = 0; i < kHalvings; ++i) {
    const double scale = 0.5 * (low + high);
    const double excess = ResponseTo(scale, height, corner, levels.solid).holes - holes;
    (excess > 0 ? high : low) = scale;
    (excess > 0 ? above : below) = excess;
  }
  const double scale = low + (high - low) * below / (below - above);
  const Response response = ResponseTo(scale, height, corner, levels.solid);
  const double variance = 0.25 / (scale * scale) - kInterpolationVariance;
  const double contrast = range / response.gap;
  return {std::max(variance, kPixelVariance), levels.gap + contrast * response.dark_gap, contrast,
          response.squareness};
}

}  // namespace topotag
