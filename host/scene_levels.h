#ifndef TOPOTAG_HOST_SCENE_LEVELS_H_
#define TOPOTAG_HOST_SCENE_LEVELS_H_

#include <string>
#include <vector>

#include "host/area_raster.h"
#include "host/backdrop.h"
#include "host/light.h"
#include "host/painting.h"
#include "topotag/renderer.h"

namespace topotag {

/// The grey levels of a scene before noise, rounding and clipping. Each area adds the difference
/// of its level to that of its ground, so that any number of edges in one pixel add up exactly;
/// so do the parts of a shadow and the instants of an exposure, each with its share. There may be
/// a million instants: they are computed one after the other, as often as they are needed. Refers
/// to the scene.
class SceneLevels {
 public:
  /// With the scene's own markers.
  /// @throws Error as RenderScene.
  explicit SceneLevels(const Scene& scene);
  /// With other paintings in their places: paintings[i] in the plane and the units of marker i.
  SceneLevels(const Scene& scene, const std::vector<Painting>& paintings);

  /// @param area  within the frame.
  /// @param levels  row-major, area.height x area.width.
  void Render(const Rect& area, std::vector<double>* levels);
  /// The pixels of the frame that a marker touches; may be empty.
  const Rect& Touched(int marker) const { return layers_[static_cast<size_t>(marker)].bounds; }

 private:
  struct Ink {
    std::vector<Point2> outline;  // pixels
    double contrast;              // to its ground
  };
  /// A painting in pixels at one instant.
  struct Snapshot {
    double weight = 1;
    std::vector<Point2> silhouette;
    std::vector<Ink> inks;
  };
  /// A painting in the plane of a marker, or in the image's (marker < 0).
  struct Layer {
    int marker;
    Painting painting;
    bool moves = false;
    bool by_rows = false;  // every row sees it elsewhere
    Snapshot still;        // unless it moves
    Rect bounds;
  };
  /// Grey levels of an area, and where there is a shadow, what they would be without it.
  struct Canvas {
    Rect area;
    std::vector<double>* lit;
    std::vector<double> unlit;
  };

  void AddLayer(int marker, const Painting& painting);
  /// Calls use(snapshot) for each instant of what row y sees.
  template <typename Use>
  void ForEachSnapshot(const Layer& layer, double y, bool with_inks, Use use) const;
  Snapshot Project(const Layer& layer, double time, bool with_inks) const;
  Rect Touched(const Layer& layer, double y, bool with_inks) const;
  void Draw(const Layer& layer, Canvas* canvas) const;
  void DrawExposure(const Layer& layer, double y, const Rect& part, Canvas* canvas) const;
  void Rasterize(const Layer& layer, double y, bool lit, AreaRaster* cover, AreaRaster* ink) const;

  const Scene& scene_;
  PixelResponse response_;
  Light light_;
  Backdrop backdrop_;
  std::vector<Layer> layers_;
};

/// The frame of a scene: its levels with noise, rounded and clipped.
Image DevelopFrame(const Scene& scene, SceneLevels* levels);

}  // namespace topotag

#endif  // TOPOTAG_HOST_SCENE_LEVELS_H_
