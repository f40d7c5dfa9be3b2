#include "host/upsample.h"

#include <algorithm>
#include <cstddef>

namespace topotag {
namespace {

// Catmull-Rom a quarter of a pixel right of the second of four samples, in 128ths.
template <typename T>
int Cubic(T a, T b, T c, T d) {
  return -9 * a + 111 * b + 29 * c - 3 * d;
}

// Doubles one row, to 8ths of a grey level, which 16 bits hold with the overshoot: even results lie
// a quarter left of a pixel, odd ones a quarter right of it.
void DoubleRow(const uint8_t* in, int width, int16_t* out) {
  const auto emit = [&](int i, int before2, int before, int after, int after2) {
    out[2 * i] = static_cast<int16_t>((Cubic<int>(after, in[i], before, before2) + 8) >> 4);
    out[2 * i + 1] = static_cast<int16_t>((Cubic<int>(before, in[i], after, after2) + 8) >> 4);
  };
  const auto at = [&](int i) { return in[std::clamp(i, 0, width - 1)]; };
  const auto emit_at_border = [&](int i) { emit(i, at(i - 2), at(i - 1), at(i + 1), at(i + 2)); };
  for (int i = 0; i < std::min(2, width); ++i) emit_at_border(i);
  for (int i = 2; i < width - 2; ++i) emit(i, in[i - 2], in[i - 1], in[i + 1], in[i + 2]);
  for (int i = std::max(2, width - 2); i < width; ++i) emit_at_border(i);
}

// Pixels a quarter below row b, towards row c.
void MixRows(const int16_t* a, const int16_t* b, const int16_t* c, const int16_t* d, int width,
             uint8_t* out) {
  for (int x = 0; x < width; ++x) {
    const int sum = Cubic<int>(a[x], b[x], c[x], d[x]);
    out[x] = static_cast<uint8_t>(std::clamp((sum + 512) >> 10, 0, 255));
  }
}

}  // namespace

ImageView Upsample(const ImageView& image, UpsampleWorkspace* workspace) {
  const int width = 2 * image.width;
  const int height = 2 * image.height;
  workspace->rows.resize(static_cast<size_t>(width) * static_cast<size_t>(image.height));
  workspace->pixels.resize(static_cast<size_t>(width) * static_cast<size_t>(height));
  const auto row = [&](int y) {
    return workspace->rows.data() +
           static_cast<ptrdiff_t>(std::clamp(y, 0, image.height - 1)) * width;
  };
  for (int y = 0; y < image.height; ++y) DoubleRow(image.row(y), image.width, row(y));
  uint8_t* out = workspace->pixels.data();
  for (int y = 0; y < image.height; ++y, out += 2 * static_cast<ptrdiff_t>(width)) {
    MixRows(row(y + 1), row(y), row(y - 1), row(y - 2), width, out);
    MixRows(row(y - 1), row(y), row(y + 1), row(y + 2), width, out + width);
  }
  return {workspace->pixels.data(), width, height, width};
}

}  // namespace topotag
