#include <algorithm>
#include <cmath>

#include "host/far_lattice.h"
#include "host/far_spots.h"

namespace topotag {
namespace {

constexpr int kSpotDepth = 12;  // grey levels

// Half a pixel to either side of a minimum among three values.
double Vertex(int left, int middle, int right) {
  const int curvature = left - 2 * middle + right;
  return curvature <= 0 ? 0 : std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5);
}

}  // namespace

void FarLattice::SetImage(const ImageView& image, int scale) {
  scale_ = scale;
  image_ = image;
  view_ = image;
  if (scale > 1) {
    const int width = image.width / scale, height = image.height / scale;
    halved_.Reserve(static_cast<size_t>(width) * static_cast<size_t>(height));
    view_ = {halved_.data(), width, height, width};
  }
  tile_cols_ = (view_.width + kTile - 1) / kTile;
  tile_rows_ = (view_.height + kTile - 1) / kTile;
  is_halved_.assign(static_cast<size_t>(tile_rows_), scale == 1);
  const size_t tiles = static_cast<size_t>(tile_cols_) * static_cast<size_t>(tile_rows_);
  if (tiles_.size() < tiles) tiles_.resize(tiles, Tile{0, 0, 0});
  const size_t pixels = static_cast<size_t>(view_.width) * static_cast<size_t>(view_.height);
  if (cell_.size() < pixels) cell_.resize(pixels, 0);
  bits_.Reserve(static_cast<size_t>(tile_cols_) * (kTile / 8));
  place_.Reserve(kMaxSpots);
  used_.Reserve(kMaxSpots);
}

// What earlier passes wrote is told by its number.
void FarLattice::SetSmoothing(int center_weight) {
  center_weight_ = center_weight;
  before_ += static_cast<uint32_t>(count_);
  count_ = 0;
  ++pass_;
  if (before_ < UINT32_MAX / 2 && pass_ < UINT32_MAX / 2) return;
  std::fill(cell_.begin(), cell_.end(), 0);
  std::fill(tiles_.begin(), tiles_.end(), Tile{0, 0, 0});
  before_ = 0;
  pass_ = 1;
}

void FarLattice::Halve(int tile_row) {
  uint8_t& is_halved = is_halved_[static_cast<size_t>(tile_row)];
  if (is_halved != 0) return;
  is_halved = 1;
  const int end = std::min((tile_row + 1) * kTile, view_.height);
  for (int y = tile_row * kTile; y < end; ++y) {
    HalveRow(image_, y, 0, view_.width, halved_.data() + static_cast<ptrdiff_t>(y) * view_.stride);
  }
}

void FarLattice::Collect(int column, int row, int around) {
  for (int r = std::max(row - around, 0); r <= std::min(row + around, tile_rows_ - 1); ++r) {
    for (int c = std::max(column - around, 0); c <= std::min(column + around, tile_cols_ - 1);
         ++c) {
      CollectTile(c, r);
    }
  }
}

void FarLattice::CollectTile(int column, int row) {
  Tile& tile = tiles_[static_cast<size_t>(row * tile_cols_ + column)];
  if (tile.pass == pass_) return;
  tile = {pass_, count_, 0};
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, tile_rows_ - 1); ++r) Halve(r);
  const int x0 = column * kTile, x1 = std::min(x0 + kTile, view_.width);
  const int end = std::min((row + 1) * kTile, view_.height);
  for (int y = row * kTile; y < end; ++y) {
    FindSpots(view_, y, x0, x1, 1, kSpotDepth, bits_.data());
    const uint8_t* const bits = bits_.data() + x0 / 8;
    for (unsigned left = bits[0] | (x1 > x0 + 8 ? bits[1] << 8 : 0); left != 0; left &= left - 1) {
      if (count_ == kMaxSpots) return;
      tile.count += Descend(x0 + __builtin_ctz(left), y);
    }
  }
}

int FarLattice::Smooth(int x, int y) const {
  const uint8_t* p = view_.row(y) + x;
  return center_weight_ * p[0] + p[-1] + p[1] + p[-view_.stride] + p[view_.stride];
}

// From a spot down to the darkest place after some smoothing, which need not be a spot itself, and
// to the vertex of its parabola. False where another one led there.
bool FarLattice::Descend(int x, int y) {
  int here = Smooth(x, y);
  for (int step = 0; step < 2; ++step) {
    const int cx = x, cy = y;
    for (int k = 0; k < 9; ++k) {
      const int qx = cx + k % 3 - 1, qy = cy + k / 3 - 1;
      const int there = Smooth(qx, qy);
      if (there < here) {
        here = there;
        x = qx;
        y = qy;
      }
    }
    if (x == cx && y == cy) break;
  }
  uint32_t& cell = cell_[static_cast<size_t>(y * view_.width + x)];
  if (cell > before_) return false;
  place_[static_cast<size_t>(count_)] = {x + Vertex(Smooth(x - 1, y), here, Smooth(x + 1, y)),
                                         y + Vertex(Smooth(x, y - 1), here, Smooth(x, y + 1))};
  used_[static_cast<size_t>(count_)] = false;
  cell = before_ + static_cast<uint32_t>(++count_);
  return true;
}

// Bilinear; 0 outside the image.
double FarLattice::Grey(Point2 p) const {
  if (!(p.x >= 0 && p.y >= 0 && p.x < view_.width - 1 && p.y < view_.height - 1)) return 0;
  const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
  const double fx = p.x - x, fy = p.y - y;
  const uint8_t* a = view_.row(y) + x;
  const uint8_t* b = a + view_.stride;
  const double upper = a[0] + fx * (a[1] - a[0]), lower = b[0] + fx * (b[1] - b[0]);
  return upper + fy * (lower - upper);
}

// The spot nearest to p, or -1.
int FarLattice::Nearest(Point2 p, double tolerance) const {
  const int x0 = std::max(static_cast<int>(std::floor(p.x - tolerance + 0.5)), 0);
  const int x1 = std::min(static_cast<int>(std::floor(p.x + tolerance + 0.5)), view_.width - 1);
  const int y0 = std::max(static_cast<int>(std::floor(p.y - tolerance + 0.5)), 0);
  const int y1 = std::min(static_cast<int>(std::floor(p.y + tolerance + 0.5)), view_.height - 1);
  int best = -1;
  double least = tolerance * tolerance;
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const uint32_t cell = cell_[static_cast<size_t>(y * view_.width + x)];
      if (cell <= before_) continue;
      const auto spot = static_cast<int>(cell - before_ - 1);
      const Point2 q = place_[static_cast<size_t>(spot)];
      const double distance = (q.x - p.x) * (q.x - p.x) + (q.y - p.y) * (q.y - p.y);
      if (distance < least) {
        least = distance;
        best = spot;
      }
    }
  }
  return best;
}

}  // namespace topotag
