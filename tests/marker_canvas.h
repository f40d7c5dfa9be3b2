#ifndef TOPOTAG_TESTS_MARKER_CANVAS_H_
#define TOPOTAG_TESTS_MARKER_CANVAS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/pipeline.h"
#include "tests/random_image.h"

namespace topotag {

// A black picture to draw on with rectangles of pixels.
class Canvas {
 public:
  Canvas(int width, int height)
      : width_(width),
        height_(height),
        white_(static_cast<size_t>(width) * static_cast<size_t>(height)) {}

  void Fill(int x, int y, int width, int height, bool white) {
    for (int row = y; row < y + height; ++row) {
      for (int col = x; col < x + width; ++col) white_[At(col, row)] = white;
    }
  }
  // `count` pixels from (x, y) on, in rows of `side`.
  void Speck(int x, int y, int count, bool white, int side = 5) {
    for (int i = 0; i < count; ++i) white_[At(x + i % side, y + i / side)] = white;
  }

  // A quarter turn, clockwise.
  Canvas Turned() const {
    Canvas turned(height_, width_);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x)
        turned.white_[turned.At(height_ - 1 - y, x)] = white_[At(x, y)];
    }
    return turned;
  }

  BitImage Bits() const {
    return MakeBits(width_, height_, [this](int x, int y) { return white_[At(x, y)]; });
  }

 private:
  size_t At(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  }

  int width_;
  int height_;
  std::vector<bool> white_;
};

// An upright n x n marker with square nodes, `unit` pixels a unit, its white area at (x, y).
struct DrawnMarker {
  int n;
  uint64_t id;
  int unit = 6;
  int x = 6;
  int y = 6;

  int side() const { return (4 * n + 1) * unit; }
  // Upper left pixels of a cell's node and hole.
  int node_x(int col) const { return x + (4 * col + 1) * unit; }
  int node_y(int row) const { return y + (4 * row + 1) * unit; }
  int hole_x(int col) const { return node_x(col) + unit; }
  int hole_y(int row) const { return node_y(row) + unit; }
  int bit(int row, int col) const {
    return static_cast<int>(id >> (n * n - 1 - (row * n + col)) & 1);
  }
  uint32_t area(int square_units) const {
    return static_cast<uint32_t>(square_units * unit * unit);
  }
};

inline void DrawHole(const DrawnMarker& m, int row, int col, Canvas* canvas) {
  canvas->Fill(m.hole_x(col), m.hole_y(row), m.unit, m.unit, true);
}

inline void Draw(const DrawnMarker& m, Canvas* canvas) {
  canvas->Fill(m.x, m.y, m.side(), m.side(), true);
  canvas->Fill(m.node_x(0), m.node_y(0), 5 * m.unit, 3 * m.unit, false);
  DrawHole(m, 0, 0, canvas);
  canvas->Fill(m.hole_x(0) + 2 * m.unit, m.hole_y(0), m.unit, m.unit, true);
  for (int row = 0; row < m.n; ++row) {
    for (int col = row == 0 ? 2 : 0; col < m.n; ++col) {
      canvas->Fill(m.node_x(col), m.node_y(row), 3 * m.unit, 3 * m.unit, false);
      if (m.bit(row, col)) DrawHole(m, row, col, canvas);
    }
  }
}

inline Canvas Drawn(const DrawnMarker& m) {
  Canvas canvas(m.x + m.side() + m.unit, m.y + m.side() + m.unit);
  Draw(m, &canvas);
  return canvas;
}

}  // namespace topotag

#endif  // TOPOTAG_TESTS_MARKER_CANVAS_H_
