// Binarization: frame, thresholds at tile corners -> packed bits. Paper: section 4.1.
// Equals scalar::Binarize (fallback/binarize.cc), where the rounding is explained.

enum { kRowsPerThreshold = 4 };

// How a call passes vectors of 512 bits depends on the target of each function: those that have
// such are never called.
#define INLINE static inline __attribute__((always_inline))

// Thresholds of 64 pixels, a byte each, from those of the columns of corners at every 16th: the
// upper halves of 16-bit sums, of the even and of the odd pixels. Steps and products wrap around;
// the sums fit. The bounds of a tile are all ones or all zeros; where they are equal, so are the
// thresholds.
INLINE ulong8 Thresholds(ushort8 corners, ushort8 floors, ushort8 ceilings) {
  const ushort16 even = (ushort16)(1, 5, 9, 13, 17, 21, 25, 29, 1, 5, 9, 13, 17, 21, 25, 29);
  const ushort16 odd = even + (ushort)2;
  const ushort8 base = ((corners * (ushort)32 + (ushort)128) | floors) & ceilings;
  const ushort8 step = (corners.s12345677 - corners) & (floors ^ ceilings);
  const ushort16 left_base = base.s0000000011111111;
  const ushort16 left_step = step.s0000000011111111;
  const ushort16 right_base = base.s2222222233333333;
  const ushort16 right_step = step.s2222222233333333;
  const ushort16 left = ((left_base + left_step * even) >> (ushort)8) |
                        ((left_base + left_step * odd) & (ushort)0xff00);
  const ushort16 right = ((right_base + right_step * even) >> (ushort)8) |
                         ((right_base + right_step * odd) & (ushort)0xff00);
  return (ulong8)(as_ulong4(left), as_ulong4(right));
}

INLINE ulong8 Join(uchar16 a, uchar16 b, uchar16 c, uchar16 d) {
  return (ulong8)(as_ulong2(a), as_ulong2(b), as_ulong2(c), as_ulong2(d));
}

// Bit i: whether byte i of the pixels is not below that of the thresholds. Eight bytes at a time:
// the difference of their lower 7 bits never borrows from the next byte; then the highest bits
// decide where they differ. The answers, bit 7 of each byte, are folded into the lowest byte.
INLINE ulong NotBelow(ulong8 pixels, ulong8 thresholds) {
  const ulong8 high = 0x8080808080808080UL;
  const ulong8 lower = (pixels | high) - (thresholds & ~high);
  const ulong8 answers = (pixels & ~thresholds) | (~(pixels ^ thresholds) & lower);
  ulong8 bits = (answers & high) >> (ulong8)7;
  bits |= bits >> (ulong8)7;
  bits |= bits >> (ulong8)14;
  bits |= bits >> (ulong8)28;
  return as_ulong(convert_uchar8(bits & (ulong8)0xff));
}

// The last word of a row, where the row ends within it.
ulong LastWord(global const uchar* row, int x, int width, ushort8 corners, ushort8 floors,
               ushort8 ceilings) {
  const ulong8 pixels = Join(LoadPixels(row, x, width), LoadPixels(row, x + 16, width),
                             LoadPixels(row, x + 32, width), LoadPixels(row, x + 48, width));
  return NotBelow(pixels, Thresholds(corners, floors, ceilings)) & ((1UL << (width - x)) - 1);
}

// One word of `item_rows` rows a work-item: a multiple of kRowsPerThreshold that divides kTile.
kernel void Binarize(global const uchar* image, ulong offset, ulong stride, int width, int height,
                     global const ushort* grid, global const char* floors,
                     global const char* ceilings, int pitch, int item_rows, global ulong* bits) {
  const int word = get_global_id(0);
  const int x = word * 64;
  const int y = (int)get_global_id(1) * item_rows;
  if (x >= width || y >= height) return;

  // Five columns of corners, four tiles; those beyond the last tile are padding, and their bits are
  // cut off. All sums fit 16 bits.
  const size_t first = (size_t)(y / kTile) * pitch + x / kTile;
  const ushort8 tile_floors = as_ushort8(convert_short8(vload8(0, floors + first)));
  const ushort8 tile_ceilings = as_ushort8(convert_short8(vload8(0, ceilings + first)));
  global const ushort* corner = grid + first;
  const ushort8 upper = vload8(0, corner);
  const ushort8 lower = vload8(0, corner + pitch);
  const int words = (width + 63) / 64;
  global const uchar* row = image + offset + y * stride;
  global ulong* out = bits + (size_t)y * words + word;
  const int y_end = min(y + item_rows, height);
  if (x + 64 <= width && all(as_short4(tile_ceilings.lo) == (short4)0)) {
    // White whatever the pixels are: most of a bright wall.
    for (int v = y; v < y_end; ++v, out += words) *out = ~0UL;
    return;
  }
  for (int v = y; v < y_end; v += kRowsPerThreshold) {
    const ushort below = v % kTile + kRowsPerThreshold / 2;
    const ushort above = kTile - below;
    const ushort8 t = (upper * above + lower * below + (ushort)(kTile / 2)) >> (ushort)4;
    const ulong8 thresholds = Thresholds(t, tile_floors, tile_ceilings);
    const int group_end = min(v + kRowsPerThreshold, y_end);
    for (int u = v; u < group_end; ++u, row += stride, out += words) {
      if (x + 64 <= width) {
        *out = NotBelow(Join(vload16(0, row + x), vload16(1, row + x), vload16(2, row + x),
                             vload16(3, row + x)),
                        thresholds);
      } else {
        *out = LastWord(row, x, width, t, tile_floors, tile_ceilings);
      }
    }
  }
}
