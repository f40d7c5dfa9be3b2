#include "host/shading.h"

#include <algorithm>
#include <cmath>

namespace topotag {
namespace {

// Largest gradient of the gaps' white by blur alone, per unit, at 1 pixel a unit; it falls with the
// square of the resolution.
constexpr float kBlurShading = 0.5F;

}  // namespace

Point2 FitShading(const Point2* tag, const NodeLevels* levels, int count) {
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0, w = 0, xw = 0, yw = 0;
  for (int i = 0; i < count; ++i) {
    const Point2 p = tag[i];
    const double white = levels[i].white;
    x += p.x;
    y += p.y;
    w += white;
    xx += p.x * p.x;
    xy += p.x * p.y;
    yy += p.y * p.y;
    xw += p.x * white;
    yw += p.y * white;
  }
  const double inverse = 1.0 / count;
  xx -= x * x * inverse;
  xy -= x * y * inverse;
  yy -= y * y * inverse;
  xw -= x * w * inverse;
  yw -= y * w * inverse;
  const double scale = 1 / (xx * yy - xy * xy);
  return {(xw * yy - yw * xy) * scale, (yw * xx - xw * xy) * scale};
}

void SetWhite(const NodeLevels* levels, int count, Point2 whole, Supports* supports) {
  Supports& s = *supports;
  const auto whole_u = static_cast<float>(whole.x);
  const auto whole_v = static_cast<float>(whole.y);
  for (int i = 0; i < count; ++i) {
    const float xu = s.xu[i], xv = s.xv[i], yu = s.yu[i], yv = s.yv[i];
    const float det = xu * yv - xv * yu;
    // Squared pixels of the shorter height of a square unit are det^2 / longest.
    const float longest = std::max(yv * yv + xv * xv, xu * xu + yu * yu);
    const float blur = kBlurShading * levels[i].white * longest / (det * det);
    const float u = levels[i].white_u - whole_u;
    const float v = levels[i].white_v - whole_v;
    const float square = u * u + v * v;
    const float trust = square > blur * blur ? 1 - blur / std::sqrt(square) : 0;
    s.white[i] = levels[i].white;
    s.white_u[i] = whole_u + trust * u;
    s.white_v[i] = whole_v + trust * v;
  }
}

}  // namespace topotag
