#include "bench/bitmap_marker.h"

#include <algorithm>
#include <cmath>

#include "tests/scene_util.h"

namespace topotag::bench {
namespace {

constexpr int kSamples = 6;  // a pixel and axis

/// Grey levels of a part of the frame, each weighted by how much of the pixel is covered.
struct Patch {
  int x0, y0, width, height;
  std::vector<float> level, cover;

  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  }
};

/// From the plane of a marker, metres, to homogeneous pixels.
Matrix3 PlaneToPixels(const Camera& camera, const SceneMarker& marker) {
  Matrix3 map{};
  for (size_t k = 0; k < 3; ++k) {
    const auto column = [&](size_t row) { return k < 2 ? marker.R[row][k] : marker.t[row]; };
    map[0][k] = camera.fx * column(0) + camera.cx * column(2);
    map[1][k] = camera.fy * column(1) + camera.cy * column(2);
    map[2][k] = column(2);
  }
  return map;
}

/// The inverse up to a factor.
Matrix3 Adjugate(const Matrix3& m) {
  Matrix3 a{};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      const size_t r = (j + 1) % 3, s = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
      a[i][j] = m[r][c] * m[s][d] - m[r][d] * m[s][c];
    }
  }
  return a;
}

Point2 Map(const Matrix3& m, double x, double y) {
  const double w = m[2][0] * x + m[2][1] * y + m[2][2];
  return {(m[0][0] * x + m[0][1] * y + m[0][2]) / w, (m[1][0] * x + m[1][1] * y + m[1][2]) / w};
}

Patch EmptyPatch(const Matrix3& to_pixels, double half, int reach, const Camera& camera) {
  Point2 low{1e9, 1e9}, high{-1e9, -1e9};
  for (const double x : {-half, half}) {
    for (const double y : {-half, half}) {
      const Point2 p = Map(to_pixels, x, y);
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  const auto clip = [](double value, int size) {
    return static_cast<int>(std::clamp<double>(value, 0, size));
  };
  Patch patch;
  patch.x0 = clip(std::floor(low.x) - reach, camera.width);
  patch.y0 = clip(std::floor(low.y) - reach, camera.height);
  patch.width = clip(std::ceil(high.x) + reach + 1, camera.width) - patch.x0;
  patch.height = clip(std::ceil(high.y) + reach + 1, camera.height) - patch.y0;
  patch.level.resize(patch.index(0, patch.height));
  patch.cover.resize(patch.level.size());
  return patch;
}

void Sample(const SceneMarker& marker, const BitmapMarker& bitmap, const Matrix3& to_pixels,
            Patch* patch) {
  const Matrix3 to_plane = Adjugate(to_pixels);
  const double cell = OuterSide(marker) / bitmap.cells;
  for (int y = 0; y < kSamples * patch->height; ++y) {
    for (int x = 0; x < kSamples * patch->width; ++x) {
      const Point2 p = Map(to_plane, patch->x0 + (x + 0.5) / kSamples - 0.5,
                           patch->y0 + (y + 0.5) / kSamples - 0.5);
      const double column = p.x / cell + bitmap.cells / 2.0, row = p.y / cell + bitmap.cells / 2.0;
      if (column < 0 || row < 0 || column >= bitmap.cells || row >= bitmap.cells) continue;
      const int i = static_cast<int>(row) * bitmap.cells + static_cast<int>(column);
      const bool white = bitmap.white[static_cast<size_t>(i)] != 0;
      const size_t at = patch->index(x / kSamples, y / kSamples);
      patch->cover[at] += 1.0f / (kSamples * kSamples);
      patch->level[at] +=
          static_cast<float>(white ? marker.white : marker.black) / (kSamples * kSamples);
    }
  }
}

/// Separable; what lies beyond the patch is not covered.
void Blur(const std::vector<float>& kernel, const Patch& patch, std::vector<float>* values) {
  const int reach = static_cast<int>(kernel.size() / 2);
  for (const bool along_x : {true, false}) {
    std::vector<float> blurred(values->size(), 0.0f);
    for (int y = 0; y < patch.height; ++y) {
      for (int x = 0; x < patch.width; ++x) {
        for (int k = -reach; k <= reach; ++k) {
          const int u = along_x ? x + k : x, v = along_x ? y : y + k;
          if (u < 0 || v < 0 || u >= patch.width || v >= patch.height) continue;
          blurred[patch.index(x, y)] +=
              kernel[static_cast<size_t>(k + reach)] * (*values)[patch.index(u, v)];
        }
      }
    }
    values->swap(blurred);
  }
}

std::vector<float> GaussianKernel(double sigma) {
  const int reach = static_cast<int>(std::ceil(4 * sigma));
  std::vector<float> kernel;
  float sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    kernel.push_back(static_cast<float>(std::exp(-k * k / (2 * sigma * sigma))));
    sum += kernel.back();
  }
  for (float& weight : kernel) weight /= sum;
  return kernel;
}

/// Box-Muller, one of the two values.
double Gaussian(test::Random* random) {
  const double radius = std::sqrt(-2 * std::log(1 - random->Uniform(0, 1)));
  return radius * std::cos(2 * M_PI * random->Uniform(0, 1));
}

}  // namespace

Image RenderBitmaps(const BenchScene& made, const std::vector<BitmapMarker>& markers) {
  if (made.random) return RenderTopoTags(made);
  const Scene& scene = made.scene;
  const Camera& camera = scene.camera;
  const std::vector<float> kernel = GaussianKernel(scene.blur);
  Scene empty = scene;
  empty.markers.clear();
  empty.noise = 0;
  Image frame = RenderScene(empty);
  for (size_t i = 0; i < scene.markers.size(); ++i) {
    const SceneMarker& marker = scene.markers[i];
    const Matrix3 to_pixels = PlaneToPixels(camera, marker);
    Patch patch =
        EmptyPatch(to_pixels, OuterSide(marker) / 2, static_cast<int>(kernel.size() / 2), camera);
    Sample(marker, markers[i], to_pixels, &patch);
    Blur(kernel, patch, &patch.level);
    Blur(kernel, patch, &patch.cover);
    for (int y = 0; y < patch.height; ++y) {
      uint8_t* row = frame.row(patch.y0 + y) + patch.x0;
      for (int x = 0; x < patch.width; ++x) {
        const size_t at = patch.index(x, y);
        const float value = patch.level[at] + (1 - patch.cover[at]) * row[x];
        row[x] = static_cast<uint8_t>(std::lround(std::clamp(value, 0.0f, 255.0f)));
      }
    }
  }
  test::Random random(scene.seed);
  for (int y = 0; y < camera.height; ++y) {
    for (uint8_t *p = frame.row(y), *end = p + camera.width; p != end; ++p) {
      const double value = *p + scene.noise * Gaussian(&random);
      *p = static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
    }
  }
  return frame;
}

}  // namespace topotag::bench
