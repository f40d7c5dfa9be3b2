// Threshold map: frame -> thresholds at tile corners. Paper: section 4.1.
// Equals scalar::ThresholdMap (fallback/threshold.cc), where the rules are explained.
//
// The grid has `rows` rows of `cols` values, `pitch` apart: a multiple of 16 that is at least
// cols + 1. The bounds of tile (r, c), floor and ceiling, are at r * pitch + c of planes of their
// own. Values in the columns from `cols` on, and bounds that are no tile's, are unspecified.

uchar16 PairMean(uchar16 a, uchar16 b) {
  return convert_uchar16((convert_ushort16(a) + convert_ushort16(b) + (ushort)1) >> (ushort)1);
}

// The tile planes have the same pitch and at least two rows more: tile (r, c) is at (r + 1, c + 1),
// so that corner (r, c) touches the entries (r, c) to (r + 1, c + 1). Entries that are no tile hold
// the extremes of nothing. One entry a work-item.
kernel void TileExtremes(global const uchar* image, ulong offset, ulong stride, int width,
                         int height, int pitch, global uchar* tile_min, global uchar* tile_max) {
  const int entry = (int)get_global_id(1) * pitch + (int)get_global_id(0);
  const int x = ((int)get_global_id(0) - 1) * kTile;
  const int y = ((int)get_global_id(1) - 1) * kTile;
  if (x < 0 || x >= width || y < 0 || y >= height) {
    tile_min[entry] = 255;
    tile_max[entry] = 0;
    return;
  }
  uchar16 lo = (uchar)255;
  uchar16 hi = (uchar)0;
  if (x + kTile <= width && y + kTile <= height) {
    global const uchar* row = image + offset + y * stride + x;
#pragma unroll
    for (int i = 0; i < kTile; i += 2) {
      const uchar16 mean =
          PairMean(vload16(0, row + i * stride), vload16(0, row + (i + 1) * stride));
      lo = min(lo, mean);
      hi = max(hi, mean);
    }
  } else {
    const uchar16 lane = (uchar16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const uchar16 outside = as_uchar16(lane >= (uchar16)(uchar)min(width - x, kTile));
    const int y_end = min(y + kTile, height);
    for (int upper = y; upper < y_end; upper += 2) {
      const int lower = min(upper + 1, height - 1);
      const uchar16 mean = PairMean(LoadPixels(image + offset + upper * stride, x, width),
                                    LoadPixels(image + offset + lower * stride, x, width));
      lo = min(lo, mean | outside);
      hi = max(hi, mean);
    }
  }
  const uchar8 lo8 = min(lo.lo, lo.hi);
  const uchar8 hi8 = max(hi.lo, hi.hi);
  const uchar4 lo4 = min(lo8.lo, lo8.hi);
  const uchar4 hi4 = max(hi8.lo, hi8.hi);
  const uchar2 lo2 = min(lo4.lo, lo4.hi);
  const uchar2 hi2 = max(hi4.lo, hi4.hi);
  tile_min[entry] = min(lo2.x, lo2.y);
  tile_max[entry] = max(hi2.x, hi2.y);
}

enum { kNone = -1 };  // a corner without a value; less than any value

short16 CornerMin(global const uchar* tiles, int pitch) {
  return convert_short16(min(min(vload16(0, tiles), vload16(0, tiles + 1)),
                             min(vload16(0, tiles + pitch), vload16(0, tiles + pitch + 1))));
}

short16 CornerMax(global const uchar* tiles, int pitch) {
  return convert_short16(max(max(vload16(0, tiles), vload16(0, tiles + 1)),
                             max(vload16(0, tiles + pitch), vload16(0, tiles + pitch + 1))));
}

// One level of the pyramid, half the sides, rounded up: the largest of up to four cells.
void Pull(global const short* fine, int pitch, int cols, int rows, global short* coarse) {
  const int coarse_cols = (cols + 1) / 2;
  const int coarse_rows = (rows + 1) / 2;
  for (int r = get_local_id(1); r < coarse_rows; r += get_local_size(1)) {
    global const short* upper = fine + 2 * r * pitch;
    global const short* lower = 2 * r + 1 < rows ? upper + pitch : upper;
    for (int c = get_local_id(0); c < coarse_cols; c += get_local_size(0)) {
      const int left = 2 * c;
      const int right = min(left + 1, cols - 1);
      coarse[r * coarse_cols + c] =
          max(max(upper[left], upper[right]), max(lower[left], lower[right]));
    }
  }
}

// A cell without a value takes that of the coarse cell above it.
void Push(global const short* coarse, int cols, int rows, global short* fine) {
  const int coarse_cols = (cols + 1) / 2;
  for (int r = get_local_id(1); r < rows; r += get_local_size(1)) {
    for (int c = get_local_id(0); c < cols; c += get_local_size(0)) {
      const short own = fine[r * cols + c];
      fine[r * cols + c] = own == kNone ? coarse[r / 2 * coarse_cols + c / 2] : own;
    }
  }
}

// The corners' values after the last level, 16 at a time; `flat` where there is no value at all.
void PushToGrid(global const short* coarse, int cols, int rows, int pitch, bool flat,
                global short* grid) {
  const int coarse_cols = (cols + 1) / 2;
  for (int r = get_local_id(1); r < rows; r += get_local_size(1)) {
    for (int c = 16 * get_local_id(0); c < cols; c += 16 * get_local_size(0)) {
      const int at = r * pitch + c;
      const short16 own = vload16(0, grid + at);
      const short8 above = vload8(0, coarse + r / 2 * coarse_cols + c / 2);
      const short16 value = select(own, above.s0011223344556677, own == (short16)kNone);
      vstore16(flat ? (short16)0 : value, 0, grid + at);
    }
  }
}

// The bounds of each tile: all of one colour where it has no contrast.
void ColourFlatTiles(global const uchar* tile_min, global const uchar* tile_max,
                     global const short* grid, int cols, int rows, int pitch, int min_contrast,
                     global uchar* floors, global uchar* ceilings) {
  for (int r = get_local_id(1); r + 1 < rows; r += get_local_size(1)) {
    for (int c = 16 * get_local_id(0); c + 1 < cols; c += 16 * get_local_size(0)) {
      const int at = r * pitch + c;
      const short16 lo = convert_short16(vload16(0, tile_min + at + pitch + 1));
      const short16 hi = convert_short16(vload16(0, tile_max + at + pitch + 1));
      const short16 corners = vload16(0, grid + at) + vload16(0, grid + at + 1) +
                              vload16(0, grid + at + pitch) + vload16(0, grid + at + pitch + 1);
      const short16 flat = hi - lo < (short16)min_contrast;
      const short16 white = (lo + hi) * (short)16 >= corners;
      vstore16(convert_uchar16(flat & ~white & (short)255), 0, floors + at);
      vstore16(convert_uchar16(~(flat & white) & (short)255), 0, ceilings + at);
    }
  }
}

// The thresholds of the default preset, in one work-group: of the corners with contrast; of the
// others by push-pull; then the bounds. `pyramid` has room for all levels and 8 more.
kernel void DefaultGrid(global const uchar* tile_min, global const uchar* tile_max, int cols,
                        int rows, int pitch, int min_contrast, int contrast_sixteenths,
                        global short* pyramid, global short* grid, global uchar* floors,
                        global uchar* ceilings) {
  const int first = 16 * get_local_id(0);
  const int step = 16 * get_local_size(0);
  for (int r = get_local_id(1); r < rows; r += get_local_size(1)) {
    for (int c = first; c < cols; c += step) {
      const int at = r * pitch + c;
      const short16 lo = CornerMin(tile_min + at, pitch);
      const short16 contrast = CornerMax(tile_max + at, pitch) - lo;
      const short16 value = lo * (short)8 + ((contrast * (short)contrast_sixteenths) >> (short)1);
      vstore16(select(value, (short16)kNone, contrast < (short16)min_contrast), 0, grid + at);
    }
  }
  barrier(CLK_GLOBAL_MEM_FENCE);

  Pull(grid, pitch, cols, rows, pyramid);
  barrier(CLK_GLOBAL_MEM_FENCE);
  int levels = 1;
  global short* level = pyramid;
  int level_cols = (cols + 1) / 2;
  int level_rows = (rows + 1) / 2;
  while (level_cols * level_rows > 1) {
    global short* const next = level + level_cols * level_rows;
    Pull(level, level_cols, level_cols, level_rows, next);
    barrier(CLK_GLOBAL_MEM_FENCE);
    level = next;
    level_cols = (level_cols + 1) / 2;
    level_rows = (level_rows + 1) / 2;
    ++levels;
  }
  const bool flat = *level == kNone;
  for (int l = levels - 1; l > 0; --l) {
    level_cols = ((cols - 1) >> l) + 1;
    level_rows = ((rows - 1) >> l) + 1;
    global short* const fine = level - level_cols * level_rows;
    Push(level, level_cols, level_rows, fine);
    barrier(CLK_GLOBAL_MEM_FENCE);
    level = fine;
  }
  PushToGrid(pyramid, cols, rows, pitch, flat, grid);
  barrier(CLK_GLOBAL_MEM_FENCE);
  ColourFlatTiles(tile_min, tile_max, grid, cols, rows, pitch, min_contrast, floors, ceilings);
}

enum { kBlock = 4, kWindow = 5, kStep = 8 };  // s1, w, s2

// Mean of one block of pixels, rounded to nearest; those outside the frame do not count.
int BlockMean(global const uchar* image, ulong stride, int width, int height, int x, int y) {
  const int x_end = min(x + kBlock, width);
  const int y_end = min(y + kBlock, height);
  int sum = 0;
  for (int v = y; v < y_end; ++v) {
    for (int u = x; u < x_end; ++u) sum += image[v * stride + u];
  }
  const int count = (x_end - x) * (y_end - y);
  return (2 * sum + count) / (2 * count);
}

// Means, not below alpha, of five whole blocks in a row, of which `pixels` is the first.
void AddRowOfBlocks(global const uchar* pixels, ulong stride, int alpha, ushort4* left,
                    int* right) {
  ushort16 sum16 = (ushort)0;
  ushort4 sum4 = (ushort)0;
  for (int i = 0; i < kBlock; ++i) {
    sum16 += convert_ushort16(vload16(0, pixels + i * stride));
    sum4 += convert_ushort4(vload4(0, pixels + i * stride + 16));
  }
  const ushort8 pairs = sum16.even + sum16.odd;
  const ushort4 sums = pairs.even + pairs.odd;
  *left += max((sums + (ushort)8) >> (ushort)4, (ushort4)(ushort)alpha);
  *right += max((sum4.x + sum4.y + sum4.z + sum4.w + 8) >> 4, alpha);
}

// The samples of the preset `paper`, sample_cols x sample_rows of them: one a work-item.
kernel void PaperSamples(global const uchar* image, ulong offset, ulong stride, int width,
                         int height, int sample_cols, int sample_rows, int alpha, int beta_eighths,
                         int bin_factor_percent, global ushort* samples) {
  const int sample_col = get_global_id(0);
  const int sample_row = get_global_id(1);
  if (sample_col >= sample_cols || sample_row >= sample_rows) return;
  image += offset;
  const int col = sample_col * kStep - kWindow / 2;
  const int row = sample_row * kStep - kWindow / 2;
  const int col_begin = max(col, 0);
  const int row_begin = max(row, 0);
  const int col_end = min(col + kWindow, (width + kBlock - 1) / kBlock);
  const int row_end = min(row + kWindow, (height + kBlock - 1) / kBlock);
  const bool whole_cols = col >= 0 && (col + kWindow) * kBlock <= width;
  ushort4 left = (ushort)0;
  int sum = 0;
  for (int r = row_begin; r < row_end; ++r) {
    if (whole_cols && (r + 1) * kBlock <= height) {
      AddRowOfBlocks(image + r * kBlock * stride + col * kBlock, stride, alpha, &left, &sum);
    } else {
      for (int c = col_begin; c < col_end; ++c) {
        sum += max(BlockMean(image, stride, width, height, c * kBlock, r * kBlock), alpha);
      }
    }
  }
  sum += left.x + left.y + left.z + left.w;
  const int count = (col_end - col_begin) * (row_end - row_begin);
  const int scaled = 8 * bin_factor_percent * sum;
  samples[sample_row * sample_cols + sample_col] =
      max((2 * scaled + 100 * count) / (200 * count), beta_eighths);
}

// The grid of the preset `paper`: linear interpolation of the samples, and bounds that bind
// nothing; one value a work-item.
kernel void PaperGrid(global const ushort* samples, int sample_cols, int sample_rows, int cols,
                      int rows, int pitch, global ushort* grid, global uchar* floors,
                      global uchar* ceilings) {
  const int col = get_global_id(0);
  const int row = get_global_id(1);
  if (col >= cols || row >= rows) return;
  const int x = clamp(8 * col - 1, 0, 16 * (sample_cols - 1));
  const int y = clamp(8 * row - 1, 0, 16 * (sample_rows - 1));
  // Where the weight is 0, the next sample need not exist.
  const int wx = x % 16;
  const int wy = y % 16;
  global const ushort* upper = samples + y / 16 * sample_cols + x / 16;
  global const ushort* lower = wy == 0 ? upper : upper + sample_cols;
  const int next = wx == 0 ? 0 : 1;
  const int top = upper[0] * (16 - wx) + upper[next] * wx;
  const int bottom = lower[0] * (16 - wx) + lower[next] * wx;
  grid[row * pitch + col] = (top * (16 - wy) + bottom * wy + 128) >> 8;
  floors[row * pitch + col] = 0;
  ceilings[row * pitch + col] = 255;
}
