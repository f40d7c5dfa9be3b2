#include "host/motion.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "host/check.h"
#include "host/quadrature.h"
#include "host/rigid_transform.h"
#include "host/tag_projector.h"

namespace topotag {
namespace {

// Without blur, the response of a pixel to a moving edge has kinks; so short panels bring their
// error below a tenth of a grey level.
constexpr double kMinPanel = 0.1;   // pixels
constexpr double kMaxPath = 20000;  // pixels

bool IsZero(const Vector3& v) { return v[0] == 0 && v[1] == 0 && v[2] == 0; }

/// How far the marker's corners move in the image between two times, at most; pixels.
double Path(const Scene& scene, int index, double from, double to) {
  const SceneMarker& marker = scene.markers[index];
  const SceneMarker first = MovedMarker(marker, from), last = MovedMarker(marker, to);
  const TagProjector a(scene, first, index), b(scene, last, index);
  const double half = 0.5 * marker.design.family.white_side() + marker.design.frame;
  double path = 0;
  for (const Point2 corner : {Point2{-half, -half}, {half, -half}, {half, half}, {-half, half}}) {
    const Point2 p = a(corner), q = b(corner);
    path = std::max(path, std::hypot(q.x - p.x, q.y - p.y));
  }
  return path;
}

}  // namespace

bool Moves(const Scene& scene, const SceneMarker& marker) {
  return (scene.exposure != 0 || scene.row_time != 0) &&
         !(IsZero(marker.velocity) && IsZero(marker.angular_velocity));
}

SceneMarker MovedMarker(const SceneMarker& marker, double seconds) {
  SceneMarker moved = marker;
  const Vector3& w = marker.angular_velocity;
  moved.R = Exp({w[0] * seconds, w[1] * seconds, w[2] * seconds}) * marker.R;
  for (size_t i = 0; i < 3; ++i) moved.t[i] += marker.velocity[i] * seconds;
  return moved;
}

std::vector<Instant> ExposureInstants(const Scene& scene, int index, double y) {
  const double middle = (y - TagProjector(scene, index)({0, 0}).y) * scene.row_time;
  if (scene.exposure == 0) return {{middle, 1}};
  const double first = middle - scene.exposure / 2;
  const double path = Path(scene, index, first, first + scene.exposure);
  if (!(path <= kMaxPath)) {
    FailArgument("marker " + std::to_string(index) + ": it moves by " + Text(path) +
                 " pixels while a row is exposed, more than " + Text(kMaxPath));
  }
  const double panel = std::max(kPanelInSigmas * scene.blur, kMinPanel);
  const int panels = std::max(1, static_cast<int>(std::ceil(path / panel)));
  std::vector<Instant> instants;
  instants.reserve(std::size(kFourNodes) * static_cast<size_t>(panels));
  ForEachNode(panels, [&](double position, double weight) {
    instants.push_back({first + position * scene.exposure, weight});
  });
  return instants;
}

}  // namespace topotag
