#include "host/light.h"

#include <algorithm>
#include <cmath>

#include "host/quadrature.h"

namespace topotag {
namespace {

constexpr double kMinPanel = 0.1;  // pixels, as for motion

using Polygon = std::vector<Point2>;

/// The part beyond normal . p = offset, possibly with edges that lie upon each other: they cancel
/// in a sum along the outline.
Polygon Beyond(const Polygon& polygon, Point2 normal, double offset) {
  Polygon part;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Point2 p = polygon[i], q = polygon[i + 1 < polygon.size() ? i + 1 : 0];
    const double a = normal.x * p.x + normal.y * p.y - offset;
    const double b = normal.x * q.x + normal.y * q.y - offset;
    if (a >= 0) part.push_back(p);
    if ((a >= 0) != (b >= 0)) {
      const double t = a / (a - b);
      part.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
    }
  }
  return part;
}

}  // namespace

Light::Light(const Scene& scene)
    : lighting_(scene.lighting),
      camera_(scene.camera),
      reach_(PixelResponse(scene.blur).reach() + 1) {
  if (!lighting_.shadow || lighting_.shadow->factor == 1) return;
  const Shadow& shadow = *lighting_.shadow;
  normal_ = {std::cos(shadow.angle), std::sin(shadow.angle)};
  const double middle = normal_.x * shadow.point.x + normal_.y * shadow.point.y;
  const double missing = 1 - shadow.factor;
  if (shadow.penumbra == 0) {
    edges_.push_back({middle, missing});
    return;
  }
  const double panel = std::max(kPanelInSigmas * scene.blur, kMinPanel);
  ForEachNode(static_cast<int>(std::ceil(shadow.penumbra / panel)),
              [&](double position, double weight) {
                const double offset = middle + (position - 0.5) * shadow.penumbra;
                edges_.push_back({offset, weight * missing});
              });
}

void Light::Add(const Polygon& polygon, double weight, AreaRaster* raster) const {
  raster->Add(polygon, weight);
  for (const Edge& edge : edges_) {
    const Polygon part = Beyond(polygon, normal_, edge.offset);
    if (part.size() >= 3) raster->Add(part, -weight * edge.share);
  }
}

void Light::AddEverywhere(const Rect& area, AreaRaster* raster) const {
  const double x0 = area.x - reach_, x1 = area.x + area.width + reach_;
  const double y0 = area.y - reach_, y1 = area.y + area.height + reach_;
  Add({{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, 1, raster);
}

void Light::Develop(int y, int x0, int width, double* levels) const {
  const double half_width = 0.5 * (camera_.width - 1), half_height = 0.5 * (camera_.height - 1);
  const double corner = std::max(half_width * half_width + half_height * half_height, 1.0);
  const double dy = y - half_height;
  const bool uniform = lighting_.gradient == Point2{} && lighting_.vignetting == 0;
  for (int i = 0; i < width && !(uniform && lighting_.gain == 1); ++i) {
    const double dx = x0 + i - half_width;
    const double tilted = 1 + lighting_.gradient.x * dx + lighting_.gradient.y * dy;
    const double shaded = 1 - lighting_.vignetting * (dx * dx + dy * dy) / corner;
    levels[i] *= lighting_.gain * std::max(tilted, 0.0) * shaded;
  }
  for (const Highlight& highlight : lighting_.highlights) {
    const double scale = -0.5 / (highlight.sigma * highlight.sigma);
    for (int i = 0; i < width; ++i) {
      const double u = x0 + i - highlight.center.x, v = y - highlight.center.y;
      levels[i] += highlight.level * std::exp(scale * (u * u + v * v));
    }
  }
}

}  // namespace topotag
