#include "host/local_map.h"

namespace topotag {

LocalMaps::LocalMaps(const TagMap& map, const Point2* tag, int count) {
  if (map.HasLens()) {
    for (int i = 0; i < count; ++i) {
      const LocalMap local(map, tag[i]);
      x[i] = local.center.x;
      y[i] = local.center.y;
      xu[i] = local.j[0];
      xv[i] = local.j[1];
      yu[i] = local.j[2];
      yv[i] = local.j[3];
    }
    return;
  }
  const Matrix3 m = map.ideal.m;
  for (int i = 0; i < count; ++i) {
    const double u = tag[i].x;
    const double v = tag[i].y;
    const double w = 1 / (m[2][0] * u + m[2][1] * v + m[2][2]);
    const double px = (m[0][0] * u + m[0][1] * v + m[0][2]) * w;
    const double py = (m[1][0] * u + m[1][1] * v + m[1][2]) * w;
    x[i] = px;
    y[i] = py;
    xu[i] = (m[0][0] - px * m[2][0]) * w;
    xv[i] = (m[0][1] - px * m[2][1]) * w;
    yu[i] = (m[1][0] - py * m[2][0]) * w;
    yv[i] = (m[1][1] - py * m[2][1]) * w;
  }
}

}  // namespace topotag
