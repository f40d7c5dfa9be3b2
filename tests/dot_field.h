#ifndef TOPOTAG_TESTS_DOT_FIELD_H_
#define TOPOTAG_TESTS_DOT_FIELD_H_

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/pipeline.h"
#include "topotag/image.h"

namespace topotag::test {

/// Dots with pitches of 4 pixels, a lattice without end, and a threshold map in which every tile
/// has contrast.
struct DotField {
  DotField() : image(640, 480) {
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        image.row(y)[x] = static_cast<uint8_t>(120 + 45 * (std::cos(x * 1.6) + std::cos(y * 1.5)));
      }
    }
    grid.Resize(image.width(), image.height());
    std::fill(grid.floor.begin(), grid.floor.end(), uint8_t{0});
    std::fill(grid.ceiling.begin(), grid.ceiling.end(), uint8_t{255});
  }

  Image image;
  ThresholdGrid grid;
};

}  // namespace topotag::test

#endif  // TOPOTAG_TESTS_DOT_FIELD_H_
