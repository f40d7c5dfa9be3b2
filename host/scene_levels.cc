#include "host/scene_levels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/motion.h"
#include "host/scene_check.h"
#include "host/tag_projector.h"
#include "topotag/error.h"

namespace topotag {
namespace {

using Polygon = std::vector<Point2>;

const Scene& Valid(const Scene& scene) {
  ValidateScene(scene);
  return scene;
}

std::vector<Painting> PaintMarkers(const Scene& scene) {
  std::vector<Painting> paintings;
  paintings.reserve(scene.markers.size());
  for (size_t i = 0; i < scene.markers.size(); ++i) {
    try {
      paintings.push_back(PaintMarker(scene.markers[i]));
    } catch (const Error& error) {
      throw Error(error.code(), "marker " + std::to_string(i) + ": " + error.what());
    }
  }
  return paintings;
}

Rect TouchedPixels(const Polygon& outline, double reach, const Camera& camera) {
  Point2 low = outline[0], high = outline[0];
  for (const Point2& p : outline) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  const auto clip = [](double value, int size) {
    return static_cast<int>(std::clamp<double>(value, 0, size));
  };
  const int x0 = clip(std::floor(low.x - reach), camera.width);
  const int y0 = clip(std::floor(low.y - reach), camera.height);
  const int x1 = clip(std::ceil(high.x + reach) + 1, camera.width);
  const int y1 = clip(std::ceil(high.y + reach) + 1, camera.height);
  return {x0, y0, x1 - x0, y1 - y0};
}

bool IsEmpty(const Rect& rect) { return rect.width <= 0 || rect.height <= 0; }

Rect Intersection(const Rect& a, const Rect& b) {
  const int x = std::max(a.x, b.x), y = std::max(a.y, b.y);
  return {x, y, std::min(a.x + a.width, b.x + b.width) - x,
          std::min(a.y + a.height, b.y + b.height) - y};
}

Rect Union(const Rect& a, const Rect& b) {
  if (IsEmpty(a)) return b;
  if (IsEmpty(b)) return a;
  const int x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x,
          std::max(a.y + a.height, b.y + b.height) - y};
}

}  // namespace

SceneLevels::SceneLevels(const Scene& scene) : SceneLevels(scene, PaintMarkers(scene)) {}

SceneLevels::SceneLevels(const Scene& scene, const std::vector<Painting>& paintings)
    : scene_(Valid(scene)), response_(scene.blur), light_(scene), backdrop_(scene) {
  layers_.reserve(paintings.size() + scene.occluders.size());
  for (size_t i = 0; i < paintings.size(); ++i) AddLayer(static_cast<int>(i), paintings[i]);
  for (const Occluder& occluder : scene.occluders) {
    AddLayer(occluder.marker, {{{{{}, 0, occluder.outline}}, occluder.level, 0}});
  }
}

void SceneLevels::AddLayer(int marker, const Painting& painting) {
  // Its values are checked before anything is computed with them.
  if (marker >= 0) TagProjector(scene_, marker);
  Layer layer{marker, painting, false, false, {}, {}};
  layer.moves = marker >= 0 && Moves(scene_, scene_.markers[static_cast<size_t>(marker)]);
  layer.by_rows = layer.moves && scene_.row_time != 0;
  if (!layer.moves) layer.still = Project(layer, 0, true);
  if (layer.by_rows) {
    for (int y = 0; y < scene_.camera.height; ++y) {
      Rect touched = Touched(layer, y, false);
      touched = Intersection(touched, {touched.x, y, touched.width, 1});
      if (!IsEmpty(touched)) layer.bounds = Union(layer.bounds, touched);
    }
  } else {
    // With the inks: what cannot be projected is an error before anything is drawn.
    layer.bounds = Touched(layer, 0, true);
  }
  layers_.push_back(std::move(layer));
}

template <typename Use>
void SceneLevels::ForEachSnapshot(const Layer& layer, double y, bool with_inks, Use use) const {
  if (!layer.moves) return use(layer.still);
  for (const Instant& instant : ExposureInstants(scene_, layer.marker, y)) {
    Snapshot snapshot = Project(layer, instant.time, with_inks);
    snapshot.weight = instant.weight;
    use(snapshot);
  }
}

SceneLevels::Snapshot SceneLevels::Project(const Layer& layer, double time, bool with_inks) const {
  Snapshot snapshot;
  if (layer.marker < 0) {
    snapshot.silhouette = layer.painting[0].outlines[0].points;
    return snapshot;
  }
  const SceneMarker marker = MovedMarker(scene_.markers[static_cast<size_t>(layer.marker)], time);
  const TagProjector project(scene_, marker, layer.marker);
  for (const PaintedArea& area : layer.painting) {
    const Outline& first = area.outlines[0];
    const int segments = first.radius > 0 ? project.CircleSegments(first) : 0;
    Polygon outline = project.Outlined(TessellateUnion(area.outlines, segments));
    if (&area == &layer.painting[0]) {
      snapshot.silhouette = std::move(outline);
      if (!with_inks) break;
    } else {
      snapshot.inks.push_back({std::move(outline), area.level - area.ground});
    }
  }
  return snapshot;
}

Rect SceneLevels::Touched(const Layer& layer, double y, bool with_inks) const {
  Rect bounds{};
  ForEachSnapshot(layer, y, with_inks, [&](const Snapshot& snapshot) {
    bounds = Union(bounds, TouchedPixels(snapshot.silhouette, response_.reach(), scene_.camera));
  });
  return bounds;
}

void SceneLevels::Render(const Rect& area, std::vector<double>* levels) {
  Canvas canvas{area, levels, {}};
  levels->resize(static_cast<size_t>(area.width) * static_cast<size_t>(area.height));
  for (int y = 0; y < area.height; ++y) {
    double* row = levels->data() + static_cast<size_t>(y) * area.width;
    backdrop_.Fill(area.y + y, area.x, area.width, row);
  }
  if (light_.shaded()) {
    canvas.unlit = *levels;
    AreaRaster light(response_, area);
    light_.AddEverywhere(area, &light);
    light.Finish();
    for (int y = 0; y < area.height; ++y) {
      double* row = levels->data() + static_cast<size_t>(y) * area.width;
      for (int x = 0; x < area.width; ++x) row[x] *= light.row(area.y + y)[x];
    }
  }
  for (const Layer& layer : layers_) Draw(layer, &canvas);
  for (int y = 0; y < area.height; ++y) {
    double* row = levels->data() + static_cast<size_t>(y) * area.width;
    light_.Develop(area.y + y, area.x, area.width, row);
  }
}

void SceneLevels::Draw(const Layer& layer, Canvas* canvas) const {
  const Rect part = Intersection(layer.bounds, canvas->area);
  if (IsEmpty(part)) return;
  if (!layer.by_rows) return DrawExposure(layer, 0, part, canvas);
  for (int y = part.y; y < part.y + part.height; ++y) {
    DrawExposure(layer, y, {part.x, y, part.width, 1}, canvas);
  }
}

// What a layer changes is the light on it times its contrast to what would be seen there, were it
// lit: exact where that is of one level.
void SceneLevels::DrawExposure(const Layer& layer, double y, const Rect& part,
                               Canvas* canvas) const {
  const double level = layer.painting[0].level;
  const auto draw = [&](bool lit, const std::vector<double>& seen, std::vector<double>* out) {
    AreaRaster cover(response_, part), ink(response_, part);
    Rasterize(layer, y, lit, &cover, &ink);
    const Rect& area = canvas->area;
    for (int row = part.y; row < part.y + part.height; ++row) {
      const double* c = cover.row(row);
      const double* i = ink.row(row);
      const size_t first =
          static_cast<size_t>(row - area.y) * area.width + static_cast<size_t>(part.x - area.x);
      for (int x = 0; x < part.width; ++x) {
        (*out)[first + x] += c[x] * (level - seen[first + x]) + i[x];
      }
    }
  };
  if (!light_.shaded()) return draw(false, *canvas->lit, canvas->lit);
  draw(true, canvas->unlit, canvas->lit);
  draw(false, canvas->unlit, &canvas->unlit);
}

void SceneLevels::Rasterize(const Layer& layer, double y, bool lit, AreaRaster* cover,
                            AreaRaster* ink) const {
  const auto add = [&](const Polygon& outline, double weight, AreaRaster* raster) {
    if (lit) {
      light_.Add(outline, weight, raster);
    } else {
      raster->Add(outline, weight);
    }
  };
  ForEachSnapshot(layer, y, true, [&](const Snapshot& snapshot) {
    add(snapshot.silhouette, snapshot.weight, cover);
    for (const Ink& part : snapshot.inks) add(part.outline, part.contrast * snapshot.weight, ink);
  });
  cover->Finish();
  ink->Finish();
}

}  // namespace topotag
