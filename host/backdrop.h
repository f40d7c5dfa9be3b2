#ifndef TOPOTAG_HOST_BACKDROP_H_
#define TOPOTAG_HOST_BACKDROP_H_

#include <vector>

#include "topotag/renderer.h"

namespace topotag {

/// A scene's frame before any marker: one grey level, or an image scaled to cover the frame, by
/// area where it shrinks and linearly where it grows. Refers to the image.
class Backdrop {
 public:
  explicit Backdrop(const Scene& scene);

  /// Grey levels of the pixels x .. x + width - 1 of row y.
  void Fill(int y, int x, int width, double* levels);

 private:
  /// Resampling of one axis: a target pixel is a weighted sum of consecutive source pixels.
  struct AxisTaps {
    std::vector<int> first;
    std::vector<std::vector<double>> weights;
  };

  static AxisTaps MakeTaps(int source, int target, double scale);

  double level_;
  ImageView image_;
  AxisTaps columns_, rows_;
  std::vector<double> blended_;  // source rows under one target row
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_BACKDROP_H_
