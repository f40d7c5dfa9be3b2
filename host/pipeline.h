#ifndef TOPOTAG_HOST_PIPELINE_H_
#define TOPOTAG_HOST_PIPELINE_H_

// The data that the backend stages hand to each other. Their contents are the same, byte for byte,
// on every backend, target, device and thread count; docs/design.md states the definitions.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/buffer.h"
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
  /// kDefault: a tile or a corner has contrast where it spans this many grey levels.
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
/// coordinates (kTile * col - 0.5, kTile * row - 0.5). Between them they are interpolated, in whole
/// grey levels, and clamped to the tile's own bounds.
struct ThresholdGrid {
  int cols = 0;  ///< ceil(width / kTile) + 1
  int rows = 0;  ///< ceil(height / kTile) + 1
  std::vector<uint16_t> value;
  /// Bounds of the thresholds in each tile, (rows - 1) x (cols - 1): 0 and 255, or 0 and 0 in a
  /// tile that is all white, or 255 and 255 in one that is all black.
  std::vector<uint8_t> floor, ceiling;

  void Resize(int image_width, int image_height) {
    cols = (image_width + kTile - 1) / kTile + 1;
    rows = (image_height + kTile - 1) / kTile + 1;
    value.resize(static_cast<size_t>(cols) * static_cast<size_t>(rows));
    floor.resize(tile(rows - 1, 0));
    ceiling.resize(floor.size());
  }
  uint16_t* row(int r) { return value.data() + static_cast<size_t>(r) * static_cast<size_t>(cols); }
  const uint16_t* row(int r) const {
    return value.data() + static_cast<size_t>(r) * static_cast<size_t>(cols);
  }
  /// Index of a tile.
  size_t tile(int r, int c) const {
    return static_cast<size_t>(r) * static_cast<size_t>(cols - 1) + static_cast<size_t>(c);
  }
};

/// One bit a pixel, 1 = white; bit x % 64 of word x / 64 of its row. Bits beyond the width are 0.
struct BitImage {
  /// Words before the first and behind the last row that may be read, by vectors, and are 0.
  static constexpr size_t kPadding = 8;

  int width = 0;
  int height = 0;
  int words = 0;  ///< per row, ceil(width / 64); rows follow one another
  std::vector<uint64_t> bits;

  /// The contents of the rows are unspecified until written.
  void Resize(int w, int h) {
    width = w;
    height = h;
    words = (w + 63) / 64;
    bits.resize(size() + 2 * kPadding);
    std::fill_n(bits.begin(), kPadding, 0);
    std::fill_n(bits.end() - kPadding, kPadding, 0);
  }
  size_t size() const { return static_cast<size_t>(words) * static_cast<size_t>(height); }
  uint64_t* row(int y) {
    return bits.data() + kPadding + static_cast<size_t>(y) * static_cast<size_t>(words);
  }
  const uint64_t* row(int y) const {
    return bits.data() + kPadding + static_cast<size_t>(y) * static_cast<size_t>(words);
  }
};

/// Noise limit of the labelling: the image is cut into blocks of 64 x 16 pixels (one word by
/// kBlockRows rows, from the first pixel on). A block in which more than kMaxBlockChanges pixels
/// differ from their left neighbour is taken as black: no marker can be read in it, and the number
/// of runs, thus time and memory, stays bounded.
inline constexpr int kBlockRows = 16;
inline constexpr int kMaxBlockChanges = 384;

/// Connected components of both colours: white 4-connected, black 8-connected, everything outside
/// the image black and one component, the outside, with the black pixels that reach the border.
///
/// A row has m + 1 runs where the colour changes m times (m is even). Run k of row y covers
/// [bound(f + k), bound(f + k + 1)), f being row_begin[y]; even runs are black, odd ones white, and
/// the first and the last run belong to the outside: their outer bounds are -1 and kOutsideBound.
///
/// A component is known by the smallest of its labels, its root; label 0 is the outside. Labels
/// grow in raster order of the first pixels, and roots in raster order of the components' first
/// pixels; but which numbers are used differs between backends. CanonicalComponents removes that.
struct Components {
  struct Range {
    uint32_t begin, end;
  };
  static constexpr int16_t kOutsideBound = 0x7fff;

  int width = 0;
  int height = 0;
  Buffer<uint32_t> row_begin;  ///< of each row, index of its first run
  Buffer<uint32_t> row_runs;   ///< of each row, m + 1
  Buffer<int16_t> bound;       ///< one more than runs in each row
  Buffer<uint32_t> label;      ///< of each run
  Buffer<uint32_t> root;       ///< of each label
  Buffer<uint32_t> parent;     ///< of each root, the root around it; of other labels, a smaller one
  Buffer<uint8_t> white;       ///< of each root, its colour
  std::vector<Range> ranges;   ///< of the labels in use, ascending; the first begins with 0

  /// One more than the largest label.
  uint32_t label_end() const { return ranges.back().end; }
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
