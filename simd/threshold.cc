#include "simd/threshold.h"

#include <algorithm>
#include <cstddef>

#include "host/workers.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/threshold.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace topotag::simd {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int16_t kNone = -1;
constexpr hn::ScalableTag<uint8_t> kU8;
constexpr hn::ScalableTag<int16_t> kI16;
constexpr hn::Rebind<uint8_t, hn::ScalableTag<int16_t>> kU8Half;

using Bytes = hn::Vec<decltype(kU8)>;

// In each 128-bit block, byte 0: the least one of `lo`, byte 8: the least one of ~hi.
Bytes BlockExtremes(Bytes lo, Bytes hi) {
  const hn::Repartition<uint64_t, decltype(kU8)> u64;
  lo = hn::Min(lo, hn::ShiftRightBytes<8>(kU8, lo));
  hi = hn::Max(hi, hn::ShiftRightBytes<8>(kU8, hi));
  auto both = hn::BitCast(
      kU8, hn::InterleaveLower(u64, hn::BitCast(u64, lo), hn::BitCast(u64, hn::Not(hi))));
  both = hn::Min(both, hn::ShiftRightBytes<4>(kU8, both));
  both = hn::Min(both, hn::ShiftRightBytes<2>(kU8, both));
  return hn::Min(both, hn::ShiftRightBytes<1>(kU8, both));
}

// Extremes of the tiles of one row of tiles.
void TileExtremes(const ImageView& image, int tile_row, uint8_t* tile_min, uint8_t* tile_max) {
  const int lanes = static_cast<int>(hn::Lanes(kU8));
  const int y_begin = tile_row * kTile;
  const int y_end = std::min(y_begin + kTile, image.height);
  HWY_ALIGN uint8_t extremes[kMaxImageSide + 2];
  int x = 0;
  for (; x + lanes <= image.width; x += lanes) {
    const uint8_t* pixels = image.row(y_begin) + x;
    auto lo = hn::Set(kU8, 255);
    auto hi = hn::Zero(kU8);
    const auto add = [&](Bytes mean) {
      lo = hn::Min(lo, mean);
      hi = hn::Max(hi, mean);
    };
    for (int pair = (y_end - y_begin) / 2; pair != 0; --pair, pixels += 2 * image.stride) {
      add(hn::AverageRound(hn::LoadU(kU8, pixels), hn::LoadU(kU8, pixels + image.stride)));
    }
    if ((y_end - y_begin) % 2 != 0) add(hn::LoadU(kU8, pixels));
    hn::Store(BlockExtremes(lo, hi), kU8, extremes + x);
  }
  for (int i = 0; i < x; i += kTile) {
    *tile_min++ = extremes[i];
    *tile_max++ = static_cast<uint8_t>(~extremes[i + 8]);
  }
  for (; x < image.width; x += kTile) {
    int lo = 255;
    int hi = 0;
    for (int y = y_begin; y < y_end; y += 2) {
      const uint8_t* upper = image.row(y);
      const uint8_t* lower = image.row(std::min(y + 1, y_end - 1));
      for (int i = x; i < std::min(x + kTile, image.width); ++i) {
        const int mean = (upper[i] + lower[i] + 1) >> 1;
        lo = std::min(lo, mean);
        hi = std::max(hi, mean);
      }
    }
    *tile_min++ = static_cast<uint8_t>(lo);
    *tile_max++ = static_cast<uint8_t>(hi);
  }
}

// Behind a row of `count` cells that was written in whole vectors.
void ClearPadding(size_t count, int16_t* row) {
  const size_t lanes = hn::Lanes(kI16);
  const size_t last = (count - 1) / lanes * lanes;
  const auto none = hn::Set(kI16, kNone);
  hn::StoreU(hn::IfThenElse(hn::FirstN(kI16, count - last), hn::LoadU(kI16, row + last), none),
             kI16, row + last);
  hn::StoreU(none, kI16, row + last + lanes);
}

// One row of corners from the rows of tiles above and below it, which begin one tile to the left.
// Fills the padding with corners without contrast.
void CornerRow(const ThresholdParams& params, int cols, ThresholdWorkspace* ws, int row,
               int16_t* value) {
  uint8_t* corner_min = ws->corner_min.data();
  uint8_t* corner_max = ws->corner_max.data();
  const auto stride = static_cast<size_t>(ws->stride);
  const size_t above = static_cast<size_t>(row) * stride;
  const auto corner = [&](const uint8_t* tile, size_t c, auto extreme) {
    return extreme(
        extreme(hn::LoadU(kU8, tile + c), hn::LoadU(kU8, tile + c + 1)),
        extreme(hn::LoadU(kU8, tile + stride + c), hn::LoadU(kU8, tile + stride + c + 1)));
  };
  const size_t count = static_cast<size_t>(cols);
  for (size_t c = 0; c < count; c += hn::Lanes(kU8)) {
    hn::StoreU(corner(ws->tile_min.data() + above, c, [](auto a, auto b) { return hn::Min(a, b); }),
               kU8, corner_min + c);
    hn::StoreU(corner(ws->tile_max.data() + above, c, [](auto a, auto b) { return hn::Max(a, b); }),
               kU8, corner_max + c);
  }
  const auto min_contrast = hn::Set(kI16, static_cast<int16_t>(params.min_contrast));
  const auto sixteenths = hn::Set(kI16, static_cast<int16_t>(params.contrast_sixteenths));
  for (size_t c = 0; c < count; c += hn::Lanes(kI16)) {
    const auto lo = hn::PromoteTo(kI16, hn::LoadU(kU8Half, corner_min + c));
    const auto hi = hn::PromoteTo(kI16, hn::LoadU(kU8Half, corner_max + c));
    const auto contrast = hn::Sub(hi, lo);
    const auto threshold =
        hn::Add(hn::ShiftLeft<3>(lo), hn::ShiftRight<1>(hn::Mul(sixteenths, contrast)));
    hn::StoreU(hn::IfThenElse(hn::Lt(contrast, min_contrast), hn::Set(kI16, kNone), threshold),
               kI16, value + c);
  }
  ClearPadding(count, value);
}

// One row of the coarse level: the largest of four cells. kNone is less than any value.
void PushRow(const int16_t* upper, const int16_t* lower, int coarse_cols, int16_t* coarse) {
  const size_t count = static_cast<size_t>(coarse_cols);
  for (size_t c = 0; c < count; c += hn::Lanes(kI16)) {
    hn::Vec<decltype(kI16)> even, odd;
    hn::LoadInterleaved2(kI16, upper + 2 * c, even, odd);
    const auto above = hn::Max(even, odd);
    hn::LoadInterleaved2(kI16, lower + 2 * c, even, odd);
    hn::StoreU(hn::Max(above, hn::Max(even, odd)), kI16, coarse + c);
  }
  ClearPadding(count, coarse);
}

// Gives the cells of a row that have no value that of the coarse cell above them.
void PullRow(const int16_t* coarse, int cols, int16_t* fine) {
  const size_t count = static_cast<size_t>(cols);
  const size_t lanes = hn::Lanes(kI16);
  HWY_ALIGN int16_t doubled[2 * HWY_MAX_BYTES / sizeof(int16_t)];
  for (size_t c = 0; c < count; c += 2 * lanes) {
    const auto from = hn::LoadU(kI16, coarse + c / 2);
    hn::StoreInterleaved2(from, from, kI16, doubled);
    for (size_t half = 0; half < 2 * lanes; half += lanes) {
      const auto own = hn::LoadU(kI16, fine + c + half);
      const auto other = hn::Load(kI16, doubled + half);
      hn::StoreU(hn::IfThenElse(hn::Gt(own, hn::Set(kI16, kNone)), own, other), kI16,
                 fine + c + half);
    }
  }
}

// One row of tiles between two rows of corners, see scalar::ColourFlatTiles. Writes whole vectors.
void ColourFlatTiles(const ThresholdParams& params, int tile_cols, const uint8_t* tile_min,
                     const uint8_t* tile_max, const int16_t* upper, const int16_t* lower,
                     uint8_t* floor, uint8_t* ceiling) {
  const auto min_contrast = hn::Set(kI16, static_cast<int16_t>(params.min_contrast));
  const auto level = hn::Set(kI16, 255);
  const size_t count = static_cast<size_t>(tile_cols);
  for (size_t c = 0; c < count; c += hn::Lanes(kI16)) {
    const auto lo = hn::PromoteTo(kI16, hn::LoadU(kU8Half, tile_min + c));
    const auto hi = hn::PromoteTo(kI16, hn::LoadU(kU8Half, tile_max + c));
    const auto corners =
        hn::Add(hn::Add(hn::LoadU(kI16, upper + c), hn::LoadU(kI16, upper + c + 1)),
                hn::Add(hn::LoadU(kI16, lower + c), hn::LoadU(kI16, lower + c + 1)));
    const auto flat = hn::Lt(hn::Sub(hi, lo), min_contrast);
    const auto black = hn::Lt(hn::ShiftLeft<4>(hn::Add(lo, hi)), corners);
    const auto flat_black = hn::IfThenElseZero(hn::And(flat, black), level);
    const auto not_flat_white = hn::IfThenElse(flat, hn::IfThenElseZero(black, level), level);
    hn::StoreU(hn::DemoteTo(kU8Half, flat_black), kU8Half, floor + c);
    hn::StoreU(hn::DemoteTo(kU8Half, not_flat_white), kU8Half, ceiling + c);
  }
}

// All levels are of the workspace; returns false where no cell has a value.
bool PushPull(ThresholdWorkspace* ws) {
  const auto row = [&](const ThresholdLevel& level, int r) {
    return ws->cells.data() + level.offset + static_cast<size_t>(r) * level.stride;
  };
  for (size_t k = 1; k < ws->levels.size(); ++k) {
    const ThresholdLevel& fine = ws->levels[k - 1];
    const ThresholdLevel& coarse = ws->levels[k];
    std::fill_n(row(fine, fine.rows),
                hwy::RoundUpTo(static_cast<size_t>(fine.cols), 2 * hn::Lanes(kI16)), kNone);
    for (int r = 0; r < coarse.rows; ++r) {
      PushRow(row(fine, 2 * r), row(fine, 2 * r + 1), coarse.cols, row(coarse, r));
    }
  }
  if (*row(ws->levels.back(), 0) == kNone) return false;
  for (size_t k = ws->levels.size() - 1; k > 0; --k) {
    const ThresholdLevel& fine = ws->levels[k - 1];
    for (int r = 0; r < fine.rows; ++r) {
      PullRow(row(ws->levels[k], r / 2), fine.cols, row(fine, r));
    }
  }
  return true;
}

}  // namespace

void Tiles(const ImageView& image, int tile_row, ThresholdWorkspace* ws) {
  const size_t first = static_cast<size_t>(tile_row + 1) * static_cast<size_t>(ws->stride);
  uint8_t* tile_min = ws->tile_min.data() + first;
  uint8_t* tile_max = ws->tile_max.data() + first;
  TileExtremes(image, tile_row, tile_min + 1, tile_max + 1);
  const int tile_cols = (image.width + kTile - 1) / kTile;
  tile_min[0] = 255;
  tile_max[0] = 0;
  // What the vectors of CornerRow reach.
  const size_t end = hwy::RoundUpTo(static_cast<size_t>(tile_cols) + 1, hn::Lanes(kU8)) + 1;
  std::fill(tile_min + 1 + tile_cols, tile_min + end, uint8_t{255});
  std::fill(tile_max + 1 + tile_cols, tile_max + end, uint8_t{0});
}

void Corners(const ThresholdParams& params, ThresholdWorkspace* ws, ThresholdGrid* grid) {
  const ThresholdLevel& finest = ws->levels[0];
  const auto cell_row = [&](int r) {
    return ws->cells.data() + static_cast<size_t>(r) * static_cast<size_t>(finest.stride);
  };
  for (int r = 0; r < finest.rows; ++r) {
    CornerRow(params, finest.cols, ws, r, cell_row(r));
  }
  if (!PushPull(ws)) {
    for (int r = 0; r < finest.rows; ++r) std::fill_n(cell_row(r), finest.cols, 0);
  }
  for (int r = 0; r < finest.rows; ++r) std::copy_n(cell_row(r), finest.cols, grid->row(r));
  for (int r = 0; r + 1 < finest.rows; ++r) {
    const size_t tiles = static_cast<size_t>(r + 1) * static_cast<size_t>(ws->stride) + 1;
    uint8_t* floor = ws->floor.data();
    uint8_t* ceiling = ws->ceiling.data();
    ColourFlatTiles(params, finest.cols - 1, ws->tile_min.data() + tiles,
                    ws->tile_max.data() + tiles, cell_row(r), cell_row(r + 1), floor, ceiling);
    std::copy_n(floor, finest.cols - 1, grid->floor.data() + grid->tile(r, 0));
    std::copy_n(ceiling, finest.cols - 1, grid->ceiling.data() + grid->tile(r, 0));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace topotag::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag::simd {
namespace {

HWY_EXPORT(Tiles);
HWY_EXPORT(Corners);

constexpr int kTileRowsPerTask = 2;
// Twice the longest vector of any target: bytes of tiles, or cells.
constexpr int kPadding = 512;

int RoundUp(int value, int multiple) { return (value + multiple - 1) / multiple * multiple; }

// Reserves everything for a grid of this size.
void Prepare(const ThresholdGrid& grid, ThresholdWorkspace* ws) {
  ws->stride = RoundUp(grid.cols + 1, kPadding) + kPadding;
  const size_t bytes = static_cast<size_t>(ws->stride) * static_cast<size_t>(grid.rows + 1);
  ws->tile_min.Reserve(bytes);
  ws->tile_max.Reserve(bytes);
  for (Buffer<uint8_t>* row : {&ws->corner_min, &ws->corner_max, &ws->floor, &ws->ceiling}) {
    row->Reserve(static_cast<size_t>(ws->stride));
  }
  // No tiles above the first and below the last row.
  for (const int row : {0, grid.rows}) {
    const size_t first = static_cast<size_t>(row) * static_cast<size_t>(ws->stride);
    std::fill_n(ws->tile_min.data() + first, ws->stride, uint8_t{255});
    std::fill_n(ws->tile_max.data() + first, ws->stride, uint8_t{0});
  }
  ws->levels.clear();
  int cols = grid.cols;
  int rows = grid.rows;
  size_t offset = 0;
  for (;;) {
    ws->levels.push_back({cols, rows, RoundUp(cols, kPadding) + kPadding, offset});
    offset += static_cast<size_t>(ws->levels.back().stride) * static_cast<size_t>(rows + 1);
    if (cols == 1 && rows == 1) break;
    cols = (cols + 1) / 2;
    rows = (rows + 1) / 2;
  }
  ws->cells.Reserve(offset);
}

}  // namespace

void ThresholdMap(const ImageView& image, const ThresholdParams& params, Workers* workers,
                  ThresholdWorkspace* workspace, ThresholdGrid* grid) {
  if (params.preset == Preset::kPaper) {
    scalar::ThresholdMap(image, params, &workspace->paper, grid);
    return;
  }
  grid->Resize(image.width, image.height);
  Prepare(*grid, workspace);
  const int tile_rows = grid->rows - 1;
  workers->For((tile_rows + kTileRowsPerTask - 1) / kTileRowsPerTask, [&](int task) {
    const int begin = task * kTileRowsPerTask;
    for (int row = begin; row < std::min(begin + kTileRowsPerTask, tile_rows); ++row) {
      HWY_DYNAMIC_DISPATCH(Tiles)(image, row, workspace);
    }
  });
  HWY_DYNAMIC_DISPATCH(Corners)(params, workspace, grid);
}

}  // namespace topotag::simd
#endif  // HWY_ONCE
