#include "host/backdrop.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace topotag {

Backdrop::Backdrop(const Scene& scene) : level_(scene.background), image_(scene.background_image) {
  if (image_.data == nullptr) return;
  const double scale = std::max(static_cast<double>(scene.camera.width) / image_.width,
                                static_cast<double>(scene.camera.height) / image_.height);
  columns_ = MakeTaps(image_.width, scene.camera.width, scale);
  rows_ = MakeTaps(image_.height, scene.camera.height, scale);
  blended_.resize(image_.width);
}

// The source pixels under each target pixel, by area; between two source pixels linearly where
// the target is finer. `scale` is target pixels per source pixel, the centres coincide.
Backdrop::AxisTaps Backdrop::MakeTaps(int source, int target, double scale) {
  AxisTaps taps;
  taps.first.reserve(static_cast<size_t>(target));
  taps.weights.reserve(static_cast<size_t>(target));
  for (int i = 0; i < target; ++i) {
    const double center = (i - 0.5 * (target - 1)) / scale + 0.5 * (source - 1);
    const double half = std::max(0.5 / scale, 0.5);
    const int first = std::clamp(static_cast<int>(std::floor(center - half + 0.5)), 0, source - 1);
    const int last =
        std::clamp(static_cast<int>(std::ceil(center + half - 0.5)), first, source - 1);
    std::vector<double> weights;
    weights.reserve(static_cast<size_t>(last - first) + 1);
    double sum = 0;
    for (int s = first; s <= last; ++s) {
      const double overlap = std::min(center + half, s + 0.5) - std::max(center - half, s - 0.5);
      weights.push_back(std::max(overlap, 1e-12));
      sum += weights.back();
    }
    for (double& weight : weights) weight /= sum;
    taps.first.push_back(first);
    taps.weights.push_back(std::move(weights));
  }
  return taps;
}

void Backdrop::Fill(int y, int x, int width, double* levels) {
  if (image_.data == nullptr) {
    std::fill(levels, levels + width, level_);
    return;
  }
  std::fill(blended_.begin(), blended_.end(), 0.0);
  const std::vector<double>& weights = rows_.weights[y];
  for (size_t k = 0; k < weights.size(); ++k) {
    const uint8_t* in = image_.row(rows_.first[y] + static_cast<int>(k));
    for (int i = 0; i < image_.width; ++i) blended_[i] += weights[k] * in[i];
  }
  for (int i = 0; i < width; ++i) {
    const std::vector<double>& taps = columns_.weights[x + i];
    levels[i] = 0;
    for (size_t k = 0; k < taps.size(); ++k) {
      levels[i] += taps[k] * blended_[columns_.first[x + i] + k];
    }
  }
}

}  // namespace topotag
