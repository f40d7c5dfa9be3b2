#ifndef TOPOTAG_HOST_LIGHT_H_
#define TOPOTAG_HOST_LIGHT_H_

#include <vector>

#include "host/area_raster.h"
#include "topotag/renderer.h"

namespace topotag {

/// The light of a scene. A shadow's edge cuts what is drawn before the lens blurs it: a penumbra is
/// the mean of so many sharp edges that pixels are right to 1e-3 grey levels for blur of 0.3
/// pixels and more.
class Light {
 public:
  explicit Light(const Scene& scene);

  bool shaded() const { return !edges_.empty(); }
  /// Adds a polygon with the light that falls on it.
  void Add(const std::vector<Point2>& polygon, double weight, AreaRaster* raster) const;
  /// Adds the light on everything, 1 outside the shadow, to a raster of this area.
  void AddEverywhere(const Rect& area, AreaRaster* raster) const;
  /// Gain, vignetting and highlights for the pixels x .. x + width - 1 of row y.
  void Develop(int y, int x, int width, double* levels) const;

 private:
  /// Beyond the line normal . p = offset this share of the light is missing.
  struct Edge {
    double offset;
    double share;
  };

  const Lighting& lighting_;
  const Camera& camera_;
  double reach_;
  Point2 normal_;
  std::vector<Edge> edges_;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_LIGHT_H_
