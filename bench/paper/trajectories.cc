#include "bench/paper/trajectories.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "bench/paper/systems.h"
#include "bench/scenes.h"
#include "tests/scene_util.h"

namespace topotag::bench::paper {
namespace {

using test::kDegree;
using test::operator*;

constexpr double kNear = 0.15, kFar = 0.6;  // metres
// To this distance the paper reads the 5x5, whose cells are the smallest, facing the camera.
constexpr double kPaperRange = 0.67;

/// Up to where a tilted marker is as large across its short side as one that faces the camera at
/// the paper's range.
double FarthestAt(double tilt) { return std::min(kFar, kPaperRange * std::cos(tilt * kDegree)); }

/// A point that wanders over the frame's middle part, once around for phase 0 .. 1.
Vector3 PlaceAt(double phase, double share, double distance) {
  const Camera camera = PaperCamera();
  const double x = share * std::sin(2 * M_PI * 2 * phase) * camera.width / 2 / camera.fx;
  const double y = share * std::sin(2 * M_PI * 3 * phase) * camera.height / 2 / camera.fy;
  return {x * distance, y * distance, distance};
}

/// Turned by `roll` in its plane, then tilted away from the line of sight; degrees.
Matrix3 Turned(const Vector3& t, double tilt, double towards, double roll) {
  return LineOfSight(t) *
         (test::RotationZ(towards * kDegree) *
          (test::RotationX(tilt * kDegree) * test::RotationZ((roll - towards) * kDegree)));
}

Trajectory Translation(int frames) {
  Trajectory sequence{"Seq #1",
                      "towards the camera and away from it, 0.15 to 0.6 m, across the frame, "
                      "facing the camera, a full turn in its plane; a wall",
                      {}};
  for (int i = 0; i < frames; ++i) {
    const double phase = (i + 0.5) / frames;
    const double distance = kNear + (kFar - kNear) * 0.5 * (1 - std::cos(2 * M_PI * phase));
    const Vector3 t = PlaceAt(phase, 0.6, distance);
    sequence.scenes.push_back(
        PaperScene(Turned(t, 0, 0, 360 * phase), t, 100000 + static_cast<uint64_t>(i)));
  }
  return sequence;
}

Trajectory Rotation(int frames) {
  Trajectory sequence{"Seq #2",
                      "tilted by 0 to 75 degrees about a turning axis, 0.15 to 0.6 m, but no "
                      "farther than 0.67 m (the paper's range of the 5x5) times the cosine of the "
                      "tilt; a wall",
                      {}};
  for (int i = 0; i < frames; ++i) {
    const double phase = (i + 0.5) / frames;
    const double tilt = 75 * std::abs(std::sin(2 * M_PI * 4 * phase));
    const double distance =
        kNear + (FarthestAt(tilt) - kNear) * 0.5 * (1 - std::cos(2 * M_PI * 3 * phase));
    const Vector3 t = PlaceAt(phase, 0.5, distance);
    sequence.scenes.push_back(PaperScene(Turned(t, tilt, 360 * 5 * phase, 360 * phase), t,
                                         200000 + static_cast<uint64_t>(i)));
  }
  return sequence;
}

Trajectory FreeMotion(int frames, const Photos& photos) {
  Trajectory sequence{
      "Seq #3",
      "free motion, 0.2 to 0.6 m, as far as in Seq #2, tilted by up to 45 degrees, blur 0.5 to 1.5 "
      "pixels, motion blur up to 2 pixels; " +
          photos.source,
      {}};
  for (int i = 0; i < frames; ++i) {
    test::Random random(300000 + static_cast<uint64_t>(i));
    const double tilt = random.Uniform(0, 45);
    const double distance = random.Uniform(0.2, FarthestAt(tilt));
    const Vector3 t = PlaceAt(random.Uniform(0, 1), 0.7, distance);
    const double roll = random.Uniform(0, 360), axis = random.Uniform(0, 360);
    const Matrix3 R = Turned(t, tilt, axis, roll);
    Scene scene = PaperScene(R, t, 300000 + static_cast<uint64_t>(i));
    scene.blur = random.Uniform(0.5, 1.5);
    scene.exposure = 0.01;
    const double pixels = random.Uniform(0, 2), angle = random.Uniform(0, 2 * M_PI);
    const double speed = pixels / scene.exposure * distance / scene.camera.fx;
    scene.markers[0].velocity = {speed * std::cos(angle), speed * std::sin(angle), 0};
    scene.background_image = photos.images[static_cast<size_t>(i) % photos.images.size()].view();
    sequence.scenes.push_back(scene);
  }
  return sequence;
}

struct Place {
  double distance;  ///< metres
  double tilt;      ///< degrees
};

/// Each tilt near and far, but 75 degrees near only.
constexpr std::array<Place, kPositions> kPlaces{{{0.2, 0},
                                                 {0.4, 0},
                                                 {0.6, 0},
                                                 {0.2, 30},
                                                 {0.4, 30},
                                                 {0.6, 30},
                                                 {0.2, 60},
                                                 {0.4, 60},
                                                 {0.2, 75},
                                                 {0.3, 75}}};

}  // namespace

std::vector<Trajectory> MakeSequences(int frames, const Photos& photos) {
  return {Translation(frames), Rotation(frames), FreeMotion(frames, photos)};
}

std::vector<Position> MakePositions(int count) {
  std::vector<Position> positions;
  for (int i = 0; i < count; ++i) {
    // Fewer than all: spread over the table.
    const int index = count == 1 ? 0 : i * (kPositions - 1) / (count - 1);
    const Place& place = kPlaces[static_cast<size_t>(index)];
    const Vector3 t = PlaceAt((index + 0.5) / kPositions, 0.4, place.distance);
    char name[32];
    std::snprintf(name, sizeof name, "%.1f m, %.0f°", place.distance, place.tilt);
    positions.push_back({name, PaperScene(Turned(t, place.tilt, 77 * index, 131 * index), t,
                                          400000 + static_cast<uint64_t>(index) * 1000)});
  }
  return positions;
}

}  // namespace topotag::bench::paper
