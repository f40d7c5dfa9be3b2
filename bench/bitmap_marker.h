#ifndef TOPOTAG_BENCH_BITMAP_MARKER_H_
#define TOPOTAG_BENCH_BITMAP_MARKER_H_

#include <cstdint>
#include <vector>

#include "bench/scenes.h"

namespace topotag::bench {

/// A square marker of cells x cells black or white squares, its white border included.
struct BitmapMarker {
  int cells = 0;
  std::vector<uint8_t> white;  ///< row-major: 1 = white, 0 = black
};

/// The frame of a scene with other markers: markers[i] stands where the scene has its marker i,
/// in the same pose and as large as ours is with its black frame. As exact as RenderScene.
Image RenderBitmaps(const Scene& scene, const std::vector<BitmapMarker>& markers);
/// Random bytes where the scene is random.
Image RenderBitmaps(const BenchScene& scene, const std::vector<BitmapMarker>& markers);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_BITMAP_MARKER_H_
