// Markers in front of a plain wall: the wall has one colour in every tile, however noisy, and the
// bit image hardly anything but the markers.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "fallback/scalar_backend.h"
#include "host/canonical.h"
#include "tests/random_image.h"
#include "tests/scene_util.h"

namespace topotag {
namespace {

constexpr int kColumns = 5, kRows = 4;

Scene TwentyMarkers(int wall, double noise) {
  test::Random random(static_cast<uint64_t>(wall));
  Scene scene;
  scene.camera = test::PinholeCamera(1280, 960, 900);
  scene.background = wall;
  scene.noise = noise;
  scene.seed = static_cast<uint64_t>(wall);
  for (int i = 0; i < kColumns * kRows; ++i) {
    SceneMarker marker;
    marker.design.family = Family(3 + i % 3);
    marker.design.id = random.Below(marker.design.family.size());
    const double z =
        test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size, 24);
    marker.R = random.Tilted(random.Uniform(0, 45) * test::kDegree);
    marker.t = {(i % kColumns + 0.5 - kColumns / 2.0) * 256 * z / 900,
                (i / kColumns + 0.5 - kRows / 2.0) * 240 * z / 900, z};
    scene.markers.push_back(marker);
  }
  return scene;
}

struct Segmented {
  explicit Segmented(const ImageView& image) {
    scalar::ScalarBackend backend;
    StageTimes times;
    backend.Binarize(image, {}, &bits, &times);
    backend.Label(bits, &components);
    grid = backend.Grid();
  }
  BitImage bits;
  Components components;
  ThresholdGrid grid;
};

// Whether the pair means of a tile span less than 20 grey levels.
bool IsFlat(const ImageView& image, int left, int top) {
  int lo = 255, hi = 0;
  for (int y = top; y < top + kTile; y += 2) {
    for (int x = left; x < left + kTile; ++x) {
      const int mean = (image.row(y)[x] + image.row(y + 1)[x] + 1) / 2;
      lo = std::min(lo, mean);
      hi = std::max(hi, mean);
    }
  }
  return hi - lo < 20;
}

bool IsOneColour(const BitImage& bits, int left, int top) {
  for (int y = top; y < top + kTile; ++y) {
    for (int x = left; x < left + kTile; ++x) {
      if (IsWhite(bits, x, y) != IsWhite(bits, left, top)) return false;
    }
  }
  return true;
}

TEST(FlatWallTest, EveryFlatTileIsOneColour) {
  for (int wall = 30; wall <= 220; wall += 38) {
    const Image image = RenderScene(TwentyMarkers(wall, 3));
    const Segmented segmented(image.view());
    int flat = 0;
    for (int y = 0; y < image.height(); y += kTile) {
      for (int x = 0; x < image.width(); x += kTile) {
        if (!IsFlat(image.view(), x, y)) continue;
        ++flat;
        EXPECT_TRUE(IsOneColour(segmented.bits, x, y)) << "wall " << wall << ", " << x << ", " << y;
      }
    }
    EXPECT_GT(flat, 800) << wall;
  }
}

// A marker is its frame, white area, nodes and holes. On a grey wall there are specks in the tiles
// that hold its edge, where the threshold passes the level of the wall; on a bright one hardly any.
TEST(FlatWallTest, NoSpecksOnTheWall) {
  for (int wall = 30; wall <= 220; wall += 10) {
    const Scene scene = TwentyMarkers(wall, 2);
    size_t expected = 2;  // the outside, the wall
    for (const SceneMarker& marker : scene.markers) {
      const int n = marker.design.family.n();
      const int bits = n * n - 2;
      expected += 2 + 1 + 2 + static_cast<size_t>(bits);
      for (int bit = 0; bit < bits; ++bit) expected += marker.design.id >> bit & 1;
    }
    const Segmented segmented(RenderScene(scene).view());
    const size_t components = CanonicalComponents(segmented.components).parent.size();
    const size_t specks_of_marker = wall < 120 ? 60 : 2;
    EXPECT_LE(components, expected + kColumns * kRows * specks_of_marker) << "wall " << wall;
  }
}

}  // namespace
}  // namespace topotag
