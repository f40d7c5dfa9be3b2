// What both stages need to read the frame. Row y of it begins at image[offset + y * stride].

enum { kTile = 16 };

// Grey levels x .. x + 15 of a row; those beyond its width are 0, and nothing outside it is read.
uchar16 LoadPixels(global const uchar* row, int x, int width) {
  if (x + 16 <= width) return vload16(0, row + x);
  ulong2 pixels = 0;
  for (int i = x; i < min(x + 8, width); ++i) pixels.x |= (ulong)row[i] << 8 * (i - x);
  for (int i = x + 8; i < min(x + 16, width); ++i) pixels.y |= (ulong)row[i] << 8 * (i - x - 8);
  return as_uchar16(pixels);
}
