#include "host/far_template.h"

#include <algorithm>
#include <cmath>

#include "host/far_model.h"

namespace topotag {
namespace {

constexpr double kBlur[] = {0.4, 0.6, 0.85, 1.2};  // units
constexpr double kPixelBlur = 0.8;                 // pixels

float Bilinear(const ImageView& image, float x, float y) {
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
  const uint8_t* a = image.row(iy) + ix;
  const uint8_t* b = image.row(iy + 1) + ix;
  const float upper = static_cast<float>(a[0]) + fx * static_cast<float>(a[1] - a[0]);
  const float lower = static_cast<float>(b[0]) + fx * static_cast<float>(b[1] - b[0]);
  return upper + fy * (lower - upper);
}

// Takes off the mean; returns the norm.
float Center(float* values, int count) {
  float sum = 0;
  for (int i = 0; i < count; ++i) sum += values[i];
  const float mean = sum / static_cast<float>(count);
  float squares = 0;
  for (int i = 0; i < count; ++i) {
    values[i] -= mean;
    squares += values[i] * values[i];
  }
  return std::sqrt(squares);
}

}  // namespace

FarTemplate::FarTemplate(const std::vector<Family>& families) {
  FarModel model;
  for (const Family& family : families) {
    const int n = family.n();
    for (size_t blur = 0; blur < kBlurs; ++blur) {
      const double variance = kBlur[blur] * kBlur[blur];
      const double covariance[3] = {variance, 0, variance};
      model.Set(family, FarModel::kSquare, covariance, 0.01);
      Samples& samples = samples_[static_cast<size_t>(n)][blur];
      for (int y = -2 * n; y <= 2 * n; ++y) {
        for (int x = -2 * n; x <= 2 * n; ++x) {
          const auto u = static_cast<float>(x), v = static_cast<float>(y);
          const FarCell cell = model.Cell(u, v);
          Quad holes{};
          for (int k = 0; k < 4; ++k) {
            const int column = cell.column + k % 2, row = cell.row + k / 2;
            const bool inside = column >= 0 && row >= 0 && column < n && row < n;
            if (inside && row * n + column >= 2) holes[k] = 0.5;
          }
          FarSample sample;
          model.Evaluate(u, v, cell, {1, -1, -1, Quad{}}, holes, &sample);
          samples.push_back(sample.value);
        }
      }
      const auto count = static_cast<int>(samples.size());
      const float norm = Center(samples.data(), count);
      for (float& value : samples) value /= norm;
    }
  }
}

double FarTemplate::Match(const ImageView& image, Family family, const Homography& map,
                          int* turns) const {
  const int n = family.n();
  const int side = family.white_side();
  const int last = side - 1;
  const double end = 2 * n;
  for (const Point2 corner : {Point2{-end, -end}, {end, -end}, {end, end}, {-end, end}}) {
    if (!(map.Denominator(corner) > 0.05)) return 0;
    const Point2 p = map.Map(corner);
    if (!(p.x >= 0 && p.y >= 0 && p.x < image.width - 1 && p.y < image.height - 1)) return 0;
  }
  std::array<float, kMaxSide * kMaxSide> grey;
  for (int r = 0; r < side; ++r) {
    for (int c = 0; c < side; ++c) {
      const Point2 p = map.Map({static_cast<double>(c - 2 * n), static_cast<double>(r - 2 * n)});
      grey[static_cast<size_t>(r * side + c)] =
          Bilinear(image, static_cast<float>(p.x), static_cast<float>(p.y));
    }
  }
  Jacobian2 j;
  map.Map({0, 0}, &j);
  const float norm = Center(grey.data(), side * side);
  if (!(norm > 0)) return 0;
  const double blur = kPixelBlur / std::sqrt(std::abs(j[0] * j[3] - j[1] * j[2]));
  size_t nearest = 0;
  while (nearest + 1 < kBlurs && blur > (kBlur[nearest] + kBlur[nearest + 1]) / 2) ++nearest;
  const float* model = samples_[static_cast<size_t>(n)][nearest].data();
  std::array<float, 4> sum{};
  for (int r = 0; r < side; ++r) {
    for (int c = 0; c < side; ++c) {
      const float m = model[r * side + c];
      sum[0] += m * grey[static_cast<size_t>(r * side + c)];
      sum[1] += m * grey[static_cast<size_t>(c * side + last - r)];
      sum[2] += m * grey[static_cast<size_t>((last - r) * side + last - c)];
      sum[3] += m * grey[static_cast<size_t>((last - c) * side + r)];
    }
  }
  *turns = static_cast<int>(std::max_element(sum.begin(), sum.end()) - sum.begin());
  return sum[static_cast<size_t>(*turns)] / norm;
}

}  // namespace topotag
