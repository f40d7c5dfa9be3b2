#ifndef TOPOTAG_HOST_PHOTOMETRIC_SCAN_H_
#define TOPOTAG_HOST_PHOTOMETRIC_SCAN_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "host/buffer.h"
#include "host/photometric_model.h"
#include "host/unit_pattern.h"

namespace topotag {

/// What the scan needs to know of each unit cell.
struct PhotometricCells {
  static constexpr int kStride = 64;  ///< cells a row
  /// Index of cell (i, j).
  static constexpr int Index(int i, int j) {
    return (j + UnitPattern::kHalf) * kStride + i + UnitPattern::kHalf;
  }
  using Table = std::array<int32_t, (2 * UnitPattern::kHalf + 1) * kStride>;
  Table flags;       ///< CellFlag; 0 beyond the marker's reach
  Table black;       ///< the window of cells around it by their bits, a row after the other
  Table background;  ///< the same
  std::array<float, kMaxVertices> holes;  ///< 1 or 0, by row and column of the node
};

enum CellFlag {
  kEdgeLeft = 1,
  kEdgeRight = 2,
  kEdgeAbove = 4,
  kEdgeBelow = 8,
  kSeesBackground = 16,  ///< somewhere in its window
  kNotUsed = 32,
  kInHole = 64  ///< it is the hole of a vertex from 2 on
};

/// Pixels by their place in the image and the cell that they see.
struct PixelList {
  Buffer<int32_t> places;  ///< y << 16 | x
  Buffer<int32_t> cells;   ///< PhotometricCells::Index
  int count = 0;

  static constexpr int kCapacity = 2 * kMaxPhotometricPixels;
  /// With what a vector, or a block, may write beyond the last pixel.
  void Reserve() {
    places.Reserve(kCapacity + 2 * kPixelLanes);
    cells.Reserve(kCapacity + 2 * kPixelLanes);
  }
};

/// Pixels that see black and white only: within reach of a hole that is no square, all others; and
/// those that see the background.
struct PixelLists {
  PixelList holes, inner, outer;
};

/// What a scan selects.
struct ScanRule {
  const PhotometricCells* cells;
  float limit;         ///< of |u| and |v|, units
  float near_square;   ///< squared widths of the point spread function from an edge
  float seen_square;   ///< the same within which a hole that is no square is seen
  float clear_square;  ///< the same within which what lies beyond the limit reaches; 0: it is known
  std::array<float, 3> u, v, w;  ///< tag point of an ideal pixel, as in PixelView
  float blur;                    ///< variance of the point spread function, square pixels
  InnerShape shape;
  int n;
};

/// Pixels of a row next to each other: pixel x + k has the ideal place (first + k step).
struct PixelRun {
  int x, y, count;
  double first_x, first_y, step_x, step_y;
};

/// Adds those pixels of a run to the lists that lie near an edge. Highway kernel: the same
/// operations in every lane of every target. The lists have room for the whole run.
void ScanRun(const ScanRule& rule, const PixelRun& run, PixelLists* lists);

/// Writes a list's pixels in blocks of fields, all but their levels and what a lens does to them.
/// What is left of the last block has no weight.
/// @param center  of the fit, pixels
void PackPixels(const ScanRule& rule, int center_x, int center_y, PixelList* list, size_t stride,
                float* blocks);

/// Writes the node fields of `count` pixels whose places are known: fields in front of them.
void PackNodeFields(const ScanRule& rule, size_t count, size_t stride, float* blocks);

}  // namespace topotag

#endif  // TOPOTAG_HOST_PHOTOMETRIC_SCAN_H_
