#include "bench/paper/resized.h"

namespace topotag::bench::paper {
namespace {

double UnitsPerMetre(const SceneMarker& marker) {
  return marker.design.family.white_side() / marker.tag_size;
}

}  // namespace

Scene WithDesign(const Scene& scene, const MarkerDesign& design, double tag_size) {
  Scene changed = scene;
  SceneMarker& marker = changed.markers[0];
  const double before = UnitsPerMetre(marker);
  marker.design = design;
  marker.tag_size = tag_size;
  const double scale = UnitsPerMetre(marker) / before;
  for (Occluder& occluder : changed.occluders) {
    if (occluder.marker < 0) continue;
    for (Point2& p : occluder.outline) p = {p.x * scale, p.y * scale};
  }
  return changed;
}

}  // namespace topotag::bench::paper
