#include "bench/paper/systems.h"

#include <algorithm>
#include <utility>

#include "tests/scene_util.h"

namespace topotag::bench::paper {
namespace {

using test::Distance;

constexpr double kFocalLength = 695;  // pixels: 98 degrees across the diagonal of 1600

Point2 Middle(const std::array<Point2, 4>& corners) {
  Point2 middle;
  for (const Point2& corner : corners) {
    middle.x += corner.x / 4;
    middle.y += corner.y / 4;
  }
  return middle;
}

}  // namespace

Camera PaperCamera() { return test::PinholeCamera(1280, 960, kFocalLength); }

Scene PaperScene(const Matrix3& R, const Vector3& t, uint64_t seed) {
  Scene scene;
  scene.camera = PaperCamera();
  scene.seed = seed;
  SceneMarker marker;
  const double white = marker.design.family.white_side();
  marker.tag_size = kMarkerSide * white / (white + 2 * marker.design.frame);
  marker.R = R;
  marker.t = t;
  scene.markers.push_back(marker);
  return scene;
}

uint64_t System::IdFor(uint64_t seed) const { return test::Random(seed).Below(dictionary_size()); }

Systems MakeSystems() {
  Systems systems = MakeOurs();
  for (auto& peer : MakePeerSystems()) systems.push_back(std::move(peer));
  return systems;
}

Systems MakeAllSystems() {
  Systems systems = MakeSystems();
  for (auto& peer : MakeRefinedPeerSystems()) systems.push_back(std::move(peer));
  return systems;
}

std::vector<Systems> MakeSystemsFor(int threads) {
  std::vector<Systems> systems;
  for (int thread = 0; thread < threads; ++thread) systems.push_back(MakeSystems());
  return systems;
}

void Tally::Add(const Tally& other) {
  frames += other.frames;
  found += other.found;
  wrong += other.wrong;
}

const Seen* FindMarker(const Scene& scene, uint64_t id, const std::vector<Seen>& markers) {
  const Detection truth = GroundTruth(scene, 0);
  double side = 0;
  for (size_t i = 0; i < 4; ++i) {
    side = std::max(side, Distance(truth.corners[i], truth.corners[(i + 1) % 4]));
  }
  for (const Seen& seen : markers) {
    if (seen.id == id && Distance(Middle(seen.corners), Middle(truth.corners)) <= side / 4) {
      return &seen;
    }
  }
  return nullptr;
}

Tally Judge(const Scene& scene, uint64_t id, const std::vector<Seen>& markers) {
  const int found = FindMarker(scene, id, markers) != nullptr ? 1 : 0;
  return {1, found, static_cast<int>(markers.size()) - found};
}

}  // namespace topotag::bench::paper
