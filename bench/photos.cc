#include "bench/photos.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "tests/scene_util.h"
#include "topotag/error.h"
#include "topotag/renderer.h"
#ifdef TOPOTAG_BENCH_WITH_FILES
#include "topotag/image_file.h"
#endif

namespace topotag::bench {
namespace {

constexpr int kTileWidth = 320;
constexpr int kTileHeight = 240;
constexpr size_t kMaxPhotos = 108;  // a mosaic of 3840 x 2160 shows each once

/// Opaque discs of all sizes, each in front of the ones before ("dead leaves"): edges at every
/// scale, as in photographs. The radii follow the density r^-3.
Image Leaves(uint64_t seed) {
  constexpr int kWidth = 2 * kTileWidth, kHeight = 2 * kTileHeight;
  constexpr double kMinRadius = 3, kMaxRadius = 200;
  test::Random random(seed);
  Image image(kWidth, kHeight);
  for (int i = 0; i < 12000; ++i) {
    const double share = random.Uniform(0, 1);
    const double low = 1 / (kMinRadius * kMinRadius), high = 1 / (kMaxRadius * kMaxRadius);
    const double radius = 1 / std::sqrt(low + share * (high - low));
    const double x = random.Uniform(0, kWidth), y = random.Uniform(0, kHeight);
    const double level = random.Uniform(20, 235);
    const double slope = random.Uniform(-0.3, 0.3);
    for (int row = std::max(0, static_cast<int>(y - radius));
         row <= std::min<double>(kHeight - 1, y + radius); ++row) {
      const double half = std::sqrt(std::max(0.0, radius * radius - (row - y) * (row - y)));
      for (int column = std::max(0, static_cast<int>(x - half));
           column <= std::min<double>(kWidth - 1, x + half); ++column) {
        const double value = level + slope * (column - x);
        image.row(row)[column] = static_cast<uint8_t>(std::clamp(value, 0.0, 255.0));
      }
    }
  }
  return image;
}

double Texture(const Image& image) {
  int64_t sum = 0;
  for (int y = 1; y < image.height(); ++y) {
    for (int x = 1; x < image.width(); ++x) {
      const int value = image.row(y)[x];
      sum += std::abs(value - image.row(y)[x - 1]) + std::abs(value - image.row(y - 1)[x]);
    }
  }
  return static_cast<double>(sum) / image.width() / image.height();
}

#ifdef TOPOTAG_BENCH_WITH_FILES
Photos FromFolder(const std::string& folder) {
  const std::vector<std::string> files = ListImages(folder);
  const size_t step = std::max<size_t>(1, files.size() / (2 * kMaxPhotos));
  Photos photos;
  for (size_t i = 0; i < files.size() && photos.images.size() < kMaxPhotos; i += step) {
    Image image = ReadImage(files[i]);
    if (image.width() < kTileWidth || image.height() < kTileHeight) continue;
    photos.images.push_back(std::move(image));
  }
  if (photos.images.empty()) {
    throw Error(ErrorCode::kFile, folder + ": no photograph of 320 x 240 pixels or more");
  }
  photos.source = std::to_string(photos.images.size()) + " photographs of a folder";
  return photos;
}
#else
[[noreturn]] Photos FromFolder(const std::string& folder) {
  throw Error(ErrorCode::kUnavailable, folder + ": this build reads no files");
}
#endif

}  // namespace

Photos LoadPhotos(const std::string& folder) {
  if (!folder.empty()) return FromFolder(folder);
  Photos photos;
  for (uint64_t seed = 1; seed <= 12; ++seed) photos.images.push_back(Leaves(seed));
  photos.source = "procedural clutter (overlapping discs), no photographs";
  return photos;
}

const Image& TypicalPhoto(const Photos& photos) {
  std::vector<std::pair<double, const Image*>> textures;
  for (const Image& image : photos.images) textures.emplace_back(Texture(image), &image);
  const auto middle = textures.begin() + static_cast<ptrdiff_t>(textures.size() / 2);
  std::nth_element(textures.begin(), middle, textures.end());
  return *middle->second;
}

Image Mosaic(const Photos& photos, int width, int height) {
  Image mosaic(width, height);
  Scene tile;
  tile.camera = test::PinholeCamera(kTileWidth, kTileHeight, kTileWidth);
  tile.noise = 0;
  size_t next = 0;
  for (int y = 0; y < height; y += kTileHeight) {
    for (int x = 0; x < width; x += kTileWidth) {
      tile.background_image = photos.images[next++ % photos.images.size()].view();
      const Image picture = RenderScene(tile);
      const size_t columns = static_cast<size_t>(std::min(kTileWidth, width - x));
      for (int row = 0; row < std::min(kTileHeight, height - y); ++row) {
        std::memcpy(mosaic.row(y + row) + x, picture.row(row), columns);
      }
    }
  }
  return mosaic;
}

}  // namespace topotag::bench
