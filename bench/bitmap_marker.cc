#include "bench/bitmap_marker.h"

#include "host/scene_levels.h"

namespace topotag::bench {
namespace {

Outline Rectangle(double x0, double y0, double x1, double y1) {
  return {{(x0 + x1) / 2, (y0 + y1) / 2}, 0, {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}};
}

/// The white square, and on it the black cells, those side by side as one area.
Painting PaintBitmap(const SceneMarker& marker, const BitmapMarker& bitmap) {
  const double units_per_metre = marker.design.family.white_side() / marker.tag_size;
  const double side = OuterSide(marker) * units_per_metre, half = side / 2;
  const double cell = side / bitmap.cells;
  Painting painting{{{Rectangle(-half, -half, half, half)}, marker.white, 0}};
  for (int row = 0; row < bitmap.cells; ++row) {
    const uint8_t* white = bitmap.white.data() + static_cast<ptrdiff_t>(row) * bitmap.cells;
    for (int first = 0; first < bitmap.cells; ++first) {
      if (white[first] != 0) continue;
      int end = first;
      while (end < bitmap.cells && white[end] == 0) ++end;
      const double x0 = first * cell - half, x1 = end * cell - half, y = row * cell - half;
      painting.push_back({{Rectangle(x0, y, x1, y + cell)}, marker.black, marker.white});
      first = end;
    }
  }
  return painting;
}

}  // namespace

Image RenderBitmaps(const Scene& scene, const std::vector<BitmapMarker>& markers) {
  std::vector<Painting> paintings;
  for (size_t i = 0; i < markers.size(); ++i) {
    paintings.push_back(PaintBitmap(scene.markers[i], markers[i]));
  }
  SceneLevels levels(scene, paintings);
  return DevelopFrame(scene, &levels);
}

Image RenderBitmaps(const BenchScene& scene, const std::vector<BitmapMarker>& markers) {
  return scene.random ? RenderTopoTags(scene) : RenderBitmaps(scene.scene, markers);
}

}  // namespace topotag::bench
