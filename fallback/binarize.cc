#include "fallback/binarize.h"

#include <algorithm>

namespace topotag::scalar {
namespace {

// Both interpolations round to nearest, halves up. The vertical one keeps the grid's fixed point
// (weights in 16ths: the group's middle lies kRowsPerThreshold / 2 pixels below its upper edge);
// the horizontal one (weights in 32ths: a pixel's centre lies half a pixel right of its left edge)
// ends in whole grey levels. Both fit 16 bits.
int VerticalThreshold(const uint16_t* upper, const uint16_t* lower, int col, int weight) {
  return (upper[col] * (kTile - weight) + lower[col] * weight + kTile / 2) / kTile;
}

}  // namespace

void ThresholdRow(const ThresholdGrid& grid, int y, int width, uint8_t* out) {
  const uint16_t* upper = grid.row(y / kTile);
  const uint16_t* lower = grid.row(y / kTile + 1);
  const int group = (y % kTile) / kRowsPerThreshold;
  const int weight = group * kRowsPerThreshold + kRowsPerThreshold / 2;
  int left = VerticalThreshold(upper, lower, 0, weight);
  for (int tile = 0; tile * kTile < width; ++tile) {
    const int right = VerticalThreshold(upper, lower, tile + 1, weight);
    const int columns = std::min(kTile, width - tile * kTile);
    const int floor = grid.floor[grid.tile(y / kTile, tile)];
    const int ceiling = grid.ceiling[grid.tile(y / kTile, tile)];
    for (int c = 0; c < columns; ++c) {
      const int sum = left * (2 * kTile - (2 * c + 1)) + right * (2 * c + 1);
      *out++ =
          static_cast<uint8_t>(std::clamp((sum + 128) >> (5 + kThresholdShift), floor, ceiling));
    }
    left = right;
  }
}

void Binarize(const ImageView& image, const ThresholdGrid& grid, BitImage* bits) {
  bits->Resize(image.width, image.height);
  uint8_t threshold[kMaxImageSide];
  for (int y = 0; y < image.height; ++y) {
    if (y % kRowsPerThreshold == 0) ThresholdRow(grid, y, image.width, threshold);
    const uint8_t* row = image.row(y);
    uint64_t* out = bits->row(y);
    for (int word = 0; word < bits->words; ++word) {
      const int begin = word * 64;
      const int count = std::min(64, image.width - begin);
      uint64_t white = 0;
      for (int i = 0; i < count; ++i) {
        white |= static_cast<uint64_t>(row[begin + i] >= threshold[begin + i]) << i;
      }
      out[word] = white;
    }
  }
}

}  // namespace topotag::scalar
