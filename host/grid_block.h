#ifndef TOPOTAG_HOST_GRID_BLOCK_H_
#define TOPOTAG_HOST_GRID_BLOCK_H_

#include "host/homography.h"
#include "host/lattice.h"

namespace topotag {

/// A crossing of the grid, units of the lattice.
inline Point2 CellPoint(int col, int row) {
  return {static_cast<double>(Lattice::kPitch * col), static_cast<double>(Lattice::kPitch * row)};
}

/// A block of n x n cells with the tag's axes turned by `turn` right angles.
struct GridBlock {
  GridBlock() = default;
  GridBlock(int first_col, int first_row, int n, int turn)
      : block_col(first_col), block_row(first_row) {
    constexpr int kCol[] = {1, 0, -1, 0};
    constexpr int kRow[] = {0, 1, 0, -1};
    x_col = kCol[turn];
    x_row = kRow[turn];
    y_col = kCol[(turn + 1) % 4];
    y_row = kRow[(turn + 1) % 4];
    col = first_col + (turn == 1 || turn == 2 ? n - 1 : 0);
    row = first_row + (turn == 2 || turn == 3 ? n - 1 : 0);
  }
  Point2 Cell(int tag_col, int tag_row) const {
    return CellPoint(col + tag_col * x_col + tag_row * y_col,
                     row + tag_col * x_row + tag_row * y_row);
  }
  // The vertex in a cell of the lattice; -1 outside the block and beside p1.
  int Vertex(int cell_col, int cell_row, int n) const {
    const int dc = cell_col - col, dr = cell_row - row;
    const int tag_col = dc * x_col + dr * x_row;
    const int tag_row = dc * y_col + dr * y_row;
    if (tag_col < 0 || tag_col >= n || tag_row < 0 || tag_row >= n) return -1;
    const int vertex = tag_row * n + tag_col;
    return vertex == 1 ? -1 : vertex;
  }
  Homography Compose(const Homography& lattice, int n) const {
    const double half = Lattice::kPitch / 2.0 * (n - 1);
    const Point2 corner = CellPoint(col, row);
    Homography map;
    for (size_t i = 0; i < 3; ++i) {
      const Vector3& m = lattice.m[i];
      const double x = m[0] * x_col + m[1] * x_row;
      const double y = m[0] * y_col + m[1] * y_row;
      map.m[i] = {x, y, m[0] * corner.x + m[1] * corner.y + m[2] + half * (x + y)};
    }
    const double scale = 1 / map.m[2][2];
    for (Vector3& r : map.m) {
      for (double& value : r) value *= scale;
    }
    return map;
  }
  int block_col = 0, block_row = 0;
  int col = 0, row = 0;  // of p1
  int x_col = 1, x_row = 0, y_col = 0, y_row = 1;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_GRID_BLOCK_H_
