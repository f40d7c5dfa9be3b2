#ifndef TOPOTAG_HOST_PHOTOMETRIC_PIXELS_H_
#define TOPOTAG_HOST_PHOTOMETRIC_PIXELS_H_

#include <array>

#include "host/photometric_model.h"
#include "host/photometric_scan.h"
#include "host/unit_pattern.h"
#include "topotag/camera.h"
#include "topotag/image.h"

namespace topotag {

/// Where pixels see the tag: the ideal pixel (x, y) from the centre (center_x, center_y) sees the
/// tag point (u . (1, x, y)) / (w . (1, x, y)), v alike.
struct PixelView {
  const Camera* camera;
  double center_x, center_y;  ///< whole ideal pixels
  std::array<double, 3> u, v, w;
  std::array<double, 3> blur;  ///< covariance of the point spread function: xx, xy, yy
};

/// Memory of CollectPixels, kept between markers.
struct PixelWorkspace {
  PhotometricCells cells;
  PixelLists lists;
  PixelBlocks blocks;

  void Reserve() {
    lists.holes.Reserve();
    lists.inner.Reserve();
    lists.outer.Reserve();
    blocks.Reserve();
  }
};

/// Collects the pixels within `reach` widths of the point spread function of an edge, in raster
/// order, those that see the background last: workspace->blocks.
/// @return how many there are
int CollectPixels(const ImageView& image, const UnitPattern& pattern, const PixelView& view,
                  double reach, PixelWorkspace* workspace);

}  // namespace topotag

#endif  // TOPOTAG_HOST_PHOTOMETRIC_PIXELS_H_
