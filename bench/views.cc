#include "bench/views.h"

#include "bench/scenes.h"
#include "tests/scene_util.h"

namespace topotag::bench {

Scene MakeView(const View& view, uint64_t seed) {
  using test::operator*;
  constexpr double kSpread = 0.2;
  test::Random random(seed);
  Scene scene;
  scene.camera = test::PinholeCamera(1280, 960, 695);
  scene.seed = seed;
  SceneMarker marker;
  marker.design.family = view.family;
  marker.design.id = random.Below(view.family.size());
  marker.design.inner =
      view.nodes.value_or(seed % 2 == 0 ? InnerShape::kSquare : InnerShape::kCircle);
  const double white = view.family.white_side();
  marker.tag_size = kViewSide * white / (white + 2 * marker.design.frame);
  const double x = random.Uniform(-kSpread, kSpread) * scene.camera.width / scene.camera.fx;
  const double y = random.Uniform(-kSpread, kSpread) * scene.camera.height / scene.camera.fy;
  marker.t = {x * view.distance, y * view.distance, view.distance};
  marker.R = LineOfSight(marker.t) * random.Tilted(view.tilt * test::kDegree);
  scene.markers.push_back(marker);
  return scene;
}

}  // namespace topotag::bench
