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

// Doubles one line of `count` samples, `step` apart: even results lie a quarter left of a sample,
// odd ones a quarter right of it.
template <typename In, typename Emit>
void DoubleLine(const In* in, int count, ptrdiff_t step, const Emit& emit) {
  const auto at = [&](int i) { return int{in[std::clamp(i, 0, count - 1) * step]}; };
  for (int i = 0; i < count; ++i) {
    emit(2 * i, Cubic(at(i + 1), at(i), at(i - 1), at(i - 2)));
    emit(2 * i + 1, Cubic(at(i - 1), at(i), at(i + 1), at(i + 2)));
  }
}

}  // namespace

ImageView Upsample(const ImageView& image, UpsampleWorkspace* workspace) {
  const int width = 2 * image.width;
  const int height = 2 * image.height;
  workspace->rows.resize(static_cast<size_t>(width) * static_cast<size_t>(image.height));
  workspace->pixels.resize(static_cast<size_t>(width) * static_cast<size_t>(height));
  // Horizontally to 8ths of a grey level, which 16 bits hold with the overshoot.
  for (int y = 0; y < image.height; ++y) {
    int16_t* out = workspace->rows.data() + static_cast<ptrdiff_t>(y) * width;
    DoubleLine(image.row(y), image.width, 1,
               [&](int x, int sum) { out[x] = static_cast<int16_t>((sum + 8) >> 4); });
  }
  for (int x = 0; x < width; ++x) {
    uint8_t* out = workspace->pixels.data() + x;
    DoubleLine(workspace->rows.data() + x, image.height, width, [&](int y, int sum) {
      out[static_cast<ptrdiff_t>(y) * width] =
          static_cast<uint8_t>(std::clamp((sum + 512) >> 10, 0, 255));
    });
  }
  return {workspace->pixels.data(), width, height, width};
}

}  // namespace topotag
