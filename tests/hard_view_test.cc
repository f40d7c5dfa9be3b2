// Markers of all sizes in one frame, at the border of strongly distorting lenses, in motion and in
// hard light: found with the right ID.

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "host/homography.h"
#include "tests/scene_util.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

using test::operator*;

SceneMarker RandomMarker(int n, test::Random* random) {
  SceneMarker marker;
  marker.design.family = Family(n);
  marker.design.id = random->Below(marker.design.family.size());
  return marker;
}

// Whether the first marker is found; nothing else may be.
bool IsFound(Detector* detector, const Scene& scene) {
  const Image image = RenderScene(scene);
  const std::vector<Detection> found = detector->detect(image.view());
  for (const Detection& d : found) {
    EXPECT_EQ(d.family, scene.markers[0].design.family);
    EXPECT_EQ(d.id, scene.markers[0].design.id);
  }
  return found.size() == 1;
}

// Units of 1 to 150 pixels.
TEST(UnitsTest, AllSizesInOneFrame) {
  struct Place {
    int unit;
    double x, y;
  };
  constexpr Place kPlaces[] = {{150, 1140, 1080}, {35, 2700, 400}, {20, 3300, 250}, {12, 3650, 500},
                               {8, 3300, 700},    {5, 3650, 800},  {3, 2300, 900},  {2, 2500, 900},
                               {1, 2700, 900},    {60, 2900, 1600}};
  Scene scene;
  scene.camera = test::PinholeCamera(3840, 2160, 3000);
  std::set<uint64_t> all, resolved;
  for (const Place& place : kPlaces) {
    SceneMarker marker;
    marker.design.family = Family(3);
    marker.design.id = 37 + all.size();
    const double z = test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size,
                                            4.0 * place.unit);
    marker.t = {(place.x - scene.camera.cx) / scene.camera.fx * z,
                (place.y - scene.camera.cy) / scene.camera.fy * z, z};
    scene.markers.push_back(marker);
    all.insert(marker.design.id);
    if (place.unit >= 2) resolved.insert(marker.design.id);
  }
  const Image image = RenderScene(scene);
  for (const bool far : {false, true}) {
    Options options;
    options.far = far;
    std::set<uint64_t> found;
    for (const Detection& d : Detector(options).detect(image.view())) {
      EXPECT_EQ(d.family, Family(3));
      found.insert(d.id);
    }
    EXPECT_EQ(found, far ? all : resolved) << (far ? "far" : "near");
  }
}

struct Lens {
  const char* name;
  Camera camera;
  double reach;  // of the markers' centres, in parts of the way from the middle to the corners
};

Lens Brown() {
  // One-to-one up to 1.09 times the distance of the corners.
  Lens lens{"brown", test::PinholeCamera(1280, 960, 1240), 0.86};
  lens.camera.model = DistortionModel::kBrown;
  lens.camera.distortion[0] = -0.3;
  return lens;
}

Lens Fisheye() {
  // Its field is 180 degrees across the width; 70 degrees from the axis.
  Lens lens{"fisheye", test::PinholeCamera(1280, 960, 1280 / M_PI), 0.62};
  lens.camera.model = DistortionModel::kFisheye;
  return lens;
}

// A rotation that takes the optical axis to `to`.
Matrix3 Facing(const Vector3& to) {
  const double norm = test::Norm(to);
  const Vector3 z{to[0] / norm, to[1] / norm, to[2] / norm};
  const double side = std::hypot(z[2], z[0]);
  const Vector3 x{z[2] / side, 0, -z[0] / side};
  const Vector3 y{z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
  return {{{x[0], y[0], z[0]}, {x[1], y[1], z[1]}, {x[2], y[2], z[2]}}};
}

class LensTest : public testing::TestWithParam<Lens> {};

TEST_P(LensTest, CornersOfTheFrame) {
  const Lens& lens = GetParam();
  Options options;
  Detector without(options);
  options.camera = lens.camera;
  options.tag_size = 0.05;
  Detector with(options);
  test::Random random(5);
  for (int i = 0; i < 12; ++i) {
    Scene scene;
    scene.camera = lens.camera;
    SceneMarker marker = RandomMarker(3 + i % 3, &random);
    const double half_width = lens.camera.width / 2.0, half_height = lens.camera.height / 2.0;
    const Point2 pixel{lens.camera.cx + (i & 1 ? 1 : -1) * lens.reach * half_width,
                       lens.camera.cy + (i & 2 ? 1 : -1) * lens.reach * half_height};
    Point2 ideal;
    ASSERT_TRUE(PixelToIdeal(&lens.camera, pixel, &ideal));
    const double distance =
        test::DistanceForPitch(lens.camera, marker.design.family, marker.tag_size, 20);
    const double x = (ideal.x - lens.camera.cx) / lens.camera.fx;
    const double y = (ideal.y - lens.camera.cy) / lens.camera.fy;
    const double z = distance / std::hypot(x, y, 1.0);
    marker.t = {x * z, y * z, z};
    marker.R = Facing(marker.t) * test::RotationZ(random.Uniform(0, 2 * M_PI));
    scene.markers = {marker};
    scene.seed = static_cast<uint64_t>(i);
    EXPECT_TRUE(IsFound(&with, scene)) << "with the camera, case " << i;
    EXPECT_TRUE(IsFound(&without, scene)) << "without it, case " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses, LensTest, testing::Values(Brown(), Fisheye()),
                         [](const auto& info) { return std::string(info.param.name); });

Scene CloseScene(int i, test::Random* random) {
  Scene scene;
  scene.camera = test::PinholeCamera(420, 420, 700);
  SceneMarker marker = RandomMarker(3 + i % 3, random);
  marker.t[2] = test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size,
                                       random->Uniform(16, 26));
  marker.R = random->Tilted(random->Uniform(0, 30) * test::kDegree);
  scene.markers = {marker};
  scene.seed = static_cast<uint64_t>(i);
  return scene;
}

// Blur of half a unit, and rows that are taken one after the other while the marker moves by a unit
// and turns.
TEST(MotionTest, BlurAndRollingShutter) {
  Detector detector;
  test::Random random(6);
  for (int i = 0; i < 12; ++i) {
    Scene scene = CloseScene(i, &random);
    SceneMarker& marker = scene.markers[0];
    const double unit = marker.tag_size / marker.design.family.white_side();  // metres
    const double angle = random.Uniform(0, 2 * M_PI);
    scene.exposure = 0.005;
    scene.row_time = (i % 2 == 0 ? 1 : -1) * 0.01 / scene.camera.height;
    const double speed = 0.5 * unit / scene.exposure;
    marker.velocity = {speed * std::cos(angle), speed * std::sin(angle), 0};
    marker.angular_velocity = {0, random.Uniform(-2, 2), random.Uniform(-2, 2)};
    EXPECT_TRUE(IsFound(&detector, scene)) << "case " << i;
  }
}

TEST(HardEdgeTest, MostMarkersAcrossAShadowAreFound) {
  Detector detector;
  test::Random random(7);
  constexpr int kFrames = 30;
  int found = 0;
  for (int i = 0; i < kFrames; ++i) {
    Scene scene = CloseScene(i, &random);
    scene.lighting.shadow = Shadow{
        {scene.camera.cx + random.Uniform(-20, 20), scene.camera.cy + random.Uniform(-20, 20)},
        random.Uniform(0, 2 * M_PI),
        0.3,
        i % 2 == 0 ? 0.0 : 5.0};
    found += IsFound(&detector, scene);
  }
  EXPECT_GE(found, kFrames / 2);
}

TEST(HardEdgeTest, AnOccluderOfTheFrameAndLowLight) {
  Detector detector;
  test::Random random(8);
  for (int i = 0; i < 9; ++i) {
    Scene scene = CloseScene(i, &random);
    scene.lighting.gain = 0.25;
    const double half = scene.markers[0].design.family.white_side() / 2.0 + 2;
    Occluder occluder;
    occluder.marker = 0;
    occluder.outline = {{-half, half - 2.5}, {half, half - 2.5}, {half, half}, {-half, half}};
    scene.occluders = {occluder};
    EXPECT_TRUE(IsFound(&detector, scene)) << "case " << i;
  }
}

}  // namespace
}  // namespace topotag
