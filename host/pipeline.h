#ifndef TOPOTAG_HOST_PIPELINE_H_
#define TOPOTAG_HOST_PIPELINE_H_

// The data that the backend stages hand to each other. Their contents are the same, byte for byte,
// on every backend, target, device and thread count; docs/design.md states the definitions.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "topotag/options.h"

namespace topotag {

/// Side of the square tiles whose corners carry the thresholds, pixels.
inline constexpr int kTile = 16;
/// Rows of pixels that share one row of thresholds.
inline constexpr int kRowsPerThreshold = 4;
/// Fixed point of the threshold grid: grey levels times 2^3.
inline constexpr int kThresholdShift = 3;
inline constexpr int kMaxThreshold = 255 << kThresholdShift;

struct ThresholdParams {
  Preset preset = Preset::kDefault;
  /// kDefault: a tile corner decides by itself where its surroundings span this many grey levels.
  int min_contrast = 20;
  /// Where between the darkest and the brightest grey level it puts the threshold. Holes and gaps
  /// are 1 unit wide, nodes 3: below the middle, blur closes fewer of them.
  int contrast_sixteenths = 7;
  /// kPaper, section 4.1; s1 = 4, w = 5 and s2 = 8 are fixed.
  int alpha = 45;
  int beta = 50;
  int bin_factor_percent = 95;
};

/// Thresholds at tile corners: node (row, col) lies on the corner between pixels, at pixel
/// coordinates (kTile * col - 0.5, kTile * row - 0.5).
struct ThresholdGrid {
  int cols = 0;  ///< ceil(width / kTile) + 1
  int rows = 0;  ///< ceil(height / kTile) + 1
  std::vector<uint16_t> value;

  void Resize(int image_width, int image_height) {
    cols = (image_width + kTile - 1) / kTile + 1;
    rows = (image_height + kTile - 1) / kTile + 1;
    value.resize(static_cast<size_t>(cols) * static_cast<size_t>(rows));
  }
  uint16_t* row(int r) { return value.data() + static_cast<size_t>(r) * static_cast<size_t>(cols); }
  const uint16_t* row(int r) const {
    return value.data() + static_cast<size_t>(r) * static_cast<size_t>(cols);
  }
};

/// One bit a pixel, 1 = white; bit x % 64 of word x / 64 of its row. Bits beyond the width are 0.
struct BitImage {
  int width = 0;
  int height = 0;
  int words = 0;  ///< per row, ceil(width / 64)
  std::vector<uint64_t> bits;

  void Resize(int w, int h) {
    width = w;
    height = h;
    words = (w + 63) / 64;
    bits.resize(static_cast<size_t>(words) * static_cast<size_t>(h));
  }
  uint64_t* row(int y) { return bits.data() + static_cast<size_t>(y) * static_cast<size_t>(words); }
  const uint64_t* row(int y) const {
    return bits.data() + static_cast<size_t>(y) * static_cast<size_t>(words);
  }
};

/// Connected components of both colours: white 4-connected, black 8-connected, everything outside
/// the image black and one component with the black pixels that reach the border.
///
/// Canonical form: component 0 is the outside; the others are numbered in raster order of their
/// first pixel. A row with the transitions t[0] < t[1] < ... < t[m-1] (x where the colour changes;
/// m is even) has m + 1 runs: run k covers [t[k-1], t[k]), even runs are black, odd ones white, and
/// the first and the last run belong to the outside.
struct Components {
  int width = 0;
  int height = 0;
  std::vector<uint32_t> row_begin;   ///< height + 1 offsets into `transition`
  std::vector<uint16_t> transition;  ///< of all rows
  std::vector<uint32_t> label;       ///< component of each run; row y's first is run_begin(y)
  std::vector<uint32_t> parent;      ///< of each component, the one around it; parent[0] = 0
  std::vector<uint8_t> white;        ///< colour of each component

  size_t size() const { return parent.size(); }
  size_t run_begin(int y) const {
    return row_begin[static_cast<size_t>(y)] + static_cast<size_t>(y);
  }
};

/// Sums over the pixels of one component within the image; x and y in pixels.
struct Feature {
  int64_t sum_x = 0;
  int64_t sum_y = 0;
  uint32_t area = 0;
  uint16_t min_x = 0xffff;  ///< bounding box, inclusive; min > max where the area is 0
  uint16_t min_y = 0xffff;
  uint16_t max_x = 0;
  uint16_t max_y = 0;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_PIPELINE_H_
