#include "fallback/threshold.h"

#include <algorithm>

namespace topotag::scalar {
namespace {

// Extremes of each tile. Noise is halved in power first: the extremes are those of the rounded-up
// means of vertically adjacent pixels in rows (0, 1), (2, 3), ...; a last odd row stands alone.
void TileExtremes(const ImageView& image, int tile_cols, int tile_rows, ThresholdWorkspace* ws) {
  const size_t tiles = static_cast<size_t>(tile_cols) * static_cast<size_t>(tile_rows);
  ws->tile_min.assign(tiles, 255);
  ws->tile_max.assign(tiles, 0);
  for (int y = 0; y < image.height; y += 2) {
    const uint8_t* upper = image.row(y);
    const uint8_t* lower = image.row(std::min(y + 1, image.height - 1));
    const size_t first = static_cast<size_t>(y / kTile) * static_cast<size_t>(tile_cols);
    for (int tile = 0; tile < tile_cols; ++tile) {
      int lo = 255;
      int hi = 0;
      const int end = std::min((tile + 1) * kTile, image.width);
      for (int x = tile * kTile; x < end; ++x) {
        const int mean = (upper[x] + lower[x] + 1) >> 1;
        lo = std::min(lo, mean);
        hi = std::max(hi, mean);
      }
      uint8_t& tile_min = ws->tile_min[first + static_cast<size_t>(tile)];
      uint8_t& tile_max = ws->tile_max[first + static_cast<size_t>(tile)];
      tile_min = static_cast<uint8_t>(std::min<int>(tile_min, lo));
      tile_max = static_cast<uint8_t>(std::max<int>(tile_max, hi));
    }
  }
}

// Extremes of each corner: of the up to four tiles that meet there.
void CornerExtremes(const ThresholdGrid& grid, ThresholdWorkspace* ws) {
  const int tile_cols = grid.cols - 1;
  const int tile_rows = grid.rows - 1;
  ws->corner_min.resize(grid.value.size());
  ws->corner_max.resize(grid.value.size());
  size_t corner = 0;
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c, ++corner) {
      uint8_t lo = 255;
      uint8_t hi = 0;
      for (int tr = std::max(r - 1, 0); tr <= std::min(r, tile_rows - 1); ++tr) {
        for (int tc = std::max(c - 1, 0); tc <= std::min(c, tile_cols - 1); ++tc) {
          const size_t tile =
              static_cast<size_t>(tr) * static_cast<size_t>(tile_cols) + static_cast<size_t>(tc);
          lo = std::min(lo, ws->tile_min[tile]);
          hi = std::max(hi, ws->tile_max[tile]);
        }
      }
      ws->corner_min[corner] = lo;
      ws->corner_max[corner] = hi;
    }
  }
}

constexpr uint16_t kNone = 0xffff;

// Replaces kNone in a cols x rows array by values of the others. Each level of the pyramid halves
// both sides (rounded up); a coarse cell is the largest of its up to four valid cells, and a cell
// without a value takes that of the coarse cell above it.
// Returns false where there is no value at all.
bool PushPull(int cols, int rows, uint16_t* fine, std::vector<uint16_t>* memory, size_t offset) {
  const size_t cells = static_cast<size_t>(cols) * static_cast<size_t>(rows);
  if (cells == 1) return fine[0] != kNone;
  const int coarse_cols = (cols + 1) / 2;
  const int coarse_rows = (rows + 1) / 2;
  uint16_t* coarse = memory->data() + offset;
  for (int r = 0; r < coarse_rows; ++r) {
    for (int c = 0; c < coarse_cols; ++c) {
      uint16_t largest = 0;
      bool found = false;
      for (int fr = 2 * r; fr < std::min(2 * r + 2, rows); ++fr) {
        for (int fc = 2 * c; fc < std::min(2 * c + 2, cols); ++fc) {
          const uint16_t value =
              fine[static_cast<size_t>(fr) * static_cast<size_t>(cols) + static_cast<size_t>(fc)];
          if (value == kNone) continue;
          largest = std::max(largest, value);
          found = true;
        }
      }
      *coarse++ = found ? largest : kNone;
    }
  }
  coarse = memory->data() + offset;
  const size_t coarse_cells = static_cast<size_t>(coarse_cols) * static_cast<size_t>(coarse_rows);
  if (!PushPull(coarse_cols, coarse_rows, coarse, memory, offset + coarse_cells)) return false;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c, ++fine) {
      if (*fine == kNone) {
        *fine = coarse[static_cast<size_t>(r / 2) * static_cast<size_t>(coarse_cols) +
                       static_cast<size_t>(c / 2)];
      }
    }
  }
  return true;
}

// Memory of all coarse levels together: less than a third of the finest, plus the rounded-up sides.
size_t PyramidSize(int cols, int rows) {
  size_t total = 0;
  while (cols > 1 || rows > 1) {
    cols = (cols + 1) / 2;
    rows = (rows + 1) / 2;
    total += static_cast<size_t>(cols) * static_cast<size_t>(rows);
  }
  return total;
}

// A tile without contrast is all of one colour: the one of the middle of its range under the mean
// threshold of its corners.
void ColourFlatTiles(const ThresholdParams& params, const ThresholdWorkspace& ws,
                     ThresholdGrid* grid) {
  for (int r = 0; r + 1 < grid->rows; ++r) {
    for (int c = 0; c + 1 < grid->cols; ++c) {
      const size_t tile = grid->tile(r, c);
      const int lo = ws.tile_min[tile];
      const int hi = ws.tile_max[tile];
      const uint16_t* upper = grid->row(r) + c;
      const uint16_t* lower = grid->row(r + 1) + c;
      const bool white = 16 * (lo + hi) >= upper[0] + upper[1] + lower[0] + lower[1];
      const bool flat = hi - lo < params.min_contrast;
      grid->floor[tile] = flat && !white ? 255 : 0;
      grid->ceiling[tile] = flat && white ? 0 : 255;
    }
  }
}

void DefaultMap(const ImageView& image, const ThresholdParams& params, ThresholdWorkspace* ws,
                ThresholdGrid* grid) {
  TileExtremes(image, grid->cols - 1, grid->rows - 1, ws);
  CornerExtremes(*grid, ws);
  const size_t corners = grid->value.size();
  for (size_t i = 0; i < corners; ++i) {
    const int contrast = ws->corner_max[i] - ws->corner_min[i];
    // Rounded down to the fixed point's 8ths of a grey level.
    grid->value[i] = contrast < params.min_contrast
                         ? kNone
                         : static_cast<uint16_t>(8 * ws->corner_min[i] +
                                                 ((params.contrast_sixteenths * contrast) >> 1));
  }
  ws->pyramid.resize(PyramidSize(grid->cols, grid->rows));
  if (!PushPull(grid->cols, grid->rows, grid->value.data(), &ws->pyramid, 0)) {
    std::fill(grid->value.begin(), grid->value.end(), uint16_t{0});
  }
  ColourFlatTiles(params, *ws, grid);
}

constexpr int kBlock = 4;         // s1
constexpr int kWindowRadius = 2;  // w = 5
constexpr int kStep = 8;          // s2

// Means of kBlock x kBlock pixels, rounded to nearest, not below alpha.
void BlockMeans(const ImageView& image, int alpha, int block_cols, int block_rows,
                std::vector<uint8_t>* blocks) {
  blocks->resize(static_cast<size_t>(block_cols) * static_cast<size_t>(block_rows));
  uint8_t* out = blocks->data();
  for (int r = 0; r < block_rows; ++r) {
    for (int c = 0; c < block_cols; ++c) {
      const int x_end = std::min((c + 1) * kBlock, image.width);
      const int y_end = std::min((r + 1) * kBlock, image.height);
      int sum = 0;
      for (int y = r * kBlock; y < y_end; ++y) {
        for (int x = c * kBlock; x < x_end; ++x) sum += image.row(y)[x];
      }
      const int count = (x_end - c * kBlock) * (y_end - r * kBlock);
      *out++ = static_cast<uint8_t>(std::max(alpha, (2 * sum + count) / (2 * count)));
    }
  }
}

// Threshold at sample (row, col) of the twice reduced image: the mean of the existing blocks of the
// window around block (kStep * row, kStep * col), times the bin factor, rounded to nearest.
int PaperSample(const std::vector<uint8_t>& blocks, int block_cols, int block_rows, int row,
                int col, const ThresholdParams& params) {
  int sum = 0;
  int count = 0;
  for (int r = std::max(kStep * row - kWindowRadius, 0);
       r <= std::min(kStep * row + kWindowRadius, block_rows - 1); ++r) {
    for (int c = std::max(kStep * col - kWindowRadius, 0);
         c <= std::min(kStep * col + kWindowRadius, block_cols - 1); ++c) {
      sum +=
          blocks[static_cast<size_t>(r) * static_cast<size_t>(block_cols) + static_cast<size_t>(c)];
      ++count;
    }
  }
  const int scaled = 8 * params.bin_factor_percent * sum;
  return std::max((2 * scaled + 100 * count) / (200 * count), params.beta << kThresholdShift);
}

// Linear interpolation position of a tile corner among the samples along one axis. A sample stands
// at the centre of its block, pixel 32 k + 1.5, a corner at 16 j - 0.5: (8 j - 1) / 16 samples.
struct SamplePosition {
  int index;
  int weight;  ///< of the next sample, sixteenths
};

SamplePosition Position(int corner, int samples) {
  const int sixteenths = std::clamp(8 * corner - 1, 0, 16 * (samples - 1));
  const int index = std::min(sixteenths / 16, std::max(samples - 2, 0));
  return {index, sixteenths - 16 * index};
}

void PaperMap(const ImageView& image, const ThresholdParams& params, ThresholdWorkspace* ws,
              ThresholdGrid* grid) {
  const int block_cols = (image.width + kBlock - 1) / kBlock;
  const int block_rows = (image.height + kBlock - 1) / kBlock;
  BlockMeans(image, params.alpha, block_cols, block_rows, &ws->blocks);
  const int cols = (block_cols - 1) / kStep + 1;
  const int rows = (block_rows - 1) / kStep + 1;
  std::vector<uint16_t>& samples = ws->pyramid;
  samples.resize(static_cast<size_t>(cols) * static_cast<size_t>(rows));
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      samples[static_cast<size_t>(r) * static_cast<size_t>(cols) + static_cast<size_t>(c)] =
          static_cast<uint16_t>(PaperSample(ws->blocks, block_cols, block_rows, r, c, params));
    }
  }
  for (int r = 0; r < grid->rows; ++r) {
    const SamplePosition py = Position(r, rows);
    const uint16_t* upper =
        samples.data() + static_cast<size_t>(py.index) * static_cast<size_t>(cols);
    const uint16_t* lower = py.weight == 0 ? upper : upper + cols;
    for (int c = 0; c < grid->cols; ++c) {
      const SamplePosition px = Position(c, cols);
      const int next = px.weight == 0 ? px.index : px.index + 1;
      const int top = upper[px.index] * (16 - px.weight) + upper[next] * px.weight;
      const int bottom = lower[px.index] * (16 - px.weight) + lower[next] * px.weight;
      grid->row(r)[c] =
          static_cast<uint16_t>((top * (16 - py.weight) + bottom * py.weight + 128) >> 8);
    }
  }
}

}  // namespace

void ThresholdMap(const ImageView& image, const ThresholdParams& params,
                  ThresholdWorkspace* workspace, ThresholdGrid* grid) {
  grid->Resize(image.width, image.height);
  if (params.preset == Preset::kPaper) {
    std::fill(grid->floor.begin(), grid->floor.end(), uint8_t{0});
    std::fill(grid->ceiling.begin(), grid->ceiling.end(), uint8_t{255});
    PaperMap(image, params, workspace, grid);
  } else {
    DefaultMap(image, params, workspace, grid);
  }
}

}  // namespace topotag::scalar
