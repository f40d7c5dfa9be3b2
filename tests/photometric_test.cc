// The photometric pose against exact renders.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/scene_util.h"
#include "tests/simd_targets.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

using test::kDegree;
using test::operator*;

Options MakeOptions(const Scene& scene) {
  Options options;
  options.camera = scene.camera;
  options.tag_size = scene.markers[0].tag_size;
  options.families = {scene.markers[0].design.family};
  options.pose = PoseMode::kPhotometric;
  options.threads = 1;
  return options;
}

// A 4x4 marker with `unit` pixels a unit where it is seen from the front.
Scene MakeScene(double unit, double tilt, const Camera& camera, uint64_t seed) {
  test::Random random(seed);
  Scene scene;
  scene.camera = camera;
  scene.seed = seed;
  SceneMarker marker;
  marker.design.id = random.Below(marker.design.family.size());
  const double z = test::DistanceForPitch(camera, marker.design.family, marker.tag_size, 4 * unit);
  marker.t = {random.Uniform(-0.1, 0.1) * z, random.Uniform(-0.1, 0.1) * z, z};
  marker.R = random.Tilted(tilt * kDegree);
  scene.markers = {marker};
  return scene;
}

Camera SmallCamera() { return test::PinholeCamera(400, 400, 700); }

struct Errors {
  double position;  ///< of the distance
  double rotation;  ///< degrees
};

Errors ErrorsOf(const PoseSolution& pose, const SceneMarker& truth) {
  return {test::Distance(pose.t, truth.t) / test::Norm(truth.t),
          test::AngleBetween(pose.R, truth.R)};
}

// The only detection, with its photometric pose.
Detection DetectOne(const Scene& scene, const Image& image) {
  const std::vector<Detection> found = Detector(MakeOptions(scene)).detect(image.view());
  EXPECT_EQ(found.size(), 1u);
  if (found.size() != 1 || !found[0].pose || !found[0].pose->photometric) {
    ADD_FAILURE() << "no photometric pose";
    return GroundTruth(scene, 0);
  }
  return found[0];
}

Detection DetectOne(const Scene& scene) { return DetectOne(scene, RenderScene(scene)); }

// Errors of the photometric poses of some scenes, root mean squares.
template <typename Change>
Errors RmsErrors(int count, double unit, double tilt, const Camera& camera, const Change& change) {
  Errors sum{};
  for (int i = 0; i < count; ++i) {
    Scene scene = MakeScene(unit, tilt, camera, static_cast<uint64_t>(100 + i));
    change(&scene);
    const Detection found = DetectOne(scene);
    EXPECT_TRUE(found.pose->photometric && found.pose->photometric->accepted) << "scene " << i;
    const Errors errors = ErrorsOf(*found.pose, scene.markers[0]);
    sum.position += errors.position * errors.position / count;
    sum.rotation += errors.rotation * errors.rotation / count;
  }
  return {std::sqrt(sum.position), std::sqrt(sum.rotation)};
}

void Paint(Image* image, Point2 center, double radius, uint8_t level) {
  for (int y = 0; y < image->height(); ++y) {
    for (int x = 0; x < image->width(); ++x) {
      if (std::hypot(x - center.x, y - center.y) < radius) image->row(y)[x] = level;
    }
  }
}

class PhotometricShapeTest : public testing::TestWithParam<InnerShape> {};

INSTANTIATE_TEST_SUITE_P(Shapes, PhotometricShapeTest,
                         testing::Values(InnerShape::kSquare, InnerShape::kCircle,
                                         InnerShape::kHexagon),
                         [](const auto& info) { return std::string(Name(info.param)); });

// The limits are one and a half to two times the Cramer-Rao bound of such scenes.
TEST_P(PhotometricShapeTest, ReachesTheBound) {
  const auto shape = [](Scene* scene) { scene->markers[0].design.inner = GetParam(); };
  const Errors frontal = RmsErrors(12, 5, 0, SmallCamera(), shape);
  EXPECT_LT(frontal.position, 6e-5);
  EXPECT_LT(frontal.rotation, 0.15);
  const Errors tilted = RmsErrors(12, 5, 35, SmallCamera(), shape);
  EXPECT_LT(tilted.position, 7e-5);
  EXPECT_LT(tilted.rotation, 0.03);
  const Errors steep = RmsErrors(12, 8, 65, SmallCamera(), shape);
  EXPECT_LT(steep.position, 7e-5);
  EXPECT_LT(steep.rotation, 0.012);
}

TEST_P(PhotometricShapeTest, HasNoBiasWithoutNoise) {
  const auto still = [](Scene* scene) {
    scene->markers[0].design.inner = GetParam();
    scene->noise = 0;
  };
  const Errors tilted = RmsErrors(8, 6, 40, SmallCamera(), still);
  EXPECT_LT(tilted.position, 2e-5);
  EXPECT_LT(tilted.rotation, 0.012);
}

TEST(PhotometricTest, LensDistortionIsPartOfTheModel) {
  Camera brown = test::PinholeCamera(640, 640, 500);
  brown.model = DistortionModel::kBrown;
  brown.distortion = {-0.25, 0.08, 0.001, -0.0005, -0.01};
  Camera fisheye = test::PinholeCamera(640, 640, 400);
  fisheye.model = DistortionModel::kFisheye;
  fisheye.distortion = {-0.01, 0.004, -0.003, 0.0005};
  for (const Camera& camera : {brown, fisheye}) {
    const Errors errors = RmsErrors(8, 5, 35, camera, [](Scene* scene) {
      scene->markers[0].t[0] += 0.25 * scene->markers[0].t[2];  // off the axis
    });
    EXPECT_LT(errors.position, 1.2e-4);
    EXPECT_LT(errors.rotation, 0.04);
  }
}

TEST(PhotometricTest, FrameMayBeMissingOrWide) {
  for (const double frame : {0.0, 2.5}) {
    const Errors errors = RmsErrors(6, 6, 35, SmallCamera(), [frame](Scene* scene) {
      scene->markers[0].design.frame = frame;
      scene->background = frame > 0 ? 200 : 60;
    });
    EXPECT_LT(errors.position, 2e-4) << frame;
    EXPECT_LT(errors.rotation, 0.06) << frame;
  }
}

TEST(PhotometricTest, InkGrowthAndBlurAreFitted) {
  Scene scene = MakeScene(6, 30, SmallCamera(), 1);
  scene.blur = 1.1;
  scene.markers[0].growth = 0.1;
  const Detection found = DetectOne(scene);
  const Photometric& photometric = *found.pose->photometric;
  EXPECT_TRUE(photometric.accepted);
  EXPECT_NEAR(photometric.blur_px, 1.1, 0.03);
  EXPECT_NEAR(photometric.growth, 0.1, 0.01);
  EXPECT_NEAR(photometric.black, 25, 2);
  EXPECT_NEAR(photometric.white, 215, 2);
  EXPECT_NEAR(photometric.sigma, 2, 0.3);
  EXPECT_LT(ErrorsOf(*found.pose, scene.markers[0]).position, 2e-4);
}

TEST(PhotometricTest, ClutterAroundTheMarkerDoesNoHarm) {
  Errors sum{};
  constexpr int kScenes = 8;
  for (int i = 0; i < kScenes; ++i) {
    const Scene scene = MakeScene(5, 30, SmallCamera(), static_cast<uint64_t>(i));
    Image image = RenderScene(scene);
    const Detection truth = GroundTruth(scene, 0);
    test::Random random(static_cast<uint64_t>(i));
    // Discs of any grey level right outside the frame.
    for (int k = 0; k < 60; ++k) {
      const double angle = random.Uniform(0, 2 * M_PI);
      const double far = 5 * 19 / std::sqrt(2.0) + random.Uniform(8, 30);
      const Point2 center{truth.center.x + far * std::cos(angle),
                          truth.center.y + far * std::sin(angle)};
      const auto grey = static_cast<uint8_t>(random.Below(256));
      Paint(&image, center, random.Uniform(2, 7), grey);
    }
    const Detection found = DetectOne(scene, image);
    EXPECT_TRUE(found.pose->photometric->accepted);
    const Errors errors = ErrorsOf(*found.pose, scene.markers[0]);
    sum.position += errors.position / kScenes;
    sum.rotation += errors.rotation / kScenes;
  }
  EXPECT_LT(sum.position, 1.2e-4);
  EXPECT_LT(sum.rotation, 0.06);
}

TEST(PhotometricTest, AHiddenNodeDoesNoHarm) {
  const Scene scene = MakeScene(6, 30, SmallCamera(), 3);
  Image image = RenderScene(scene);
  Detection found = DetectOne(scene, image);
  Paint(&image, found.vertices[9], 8, 120);
  Detector detector(MakeOptions(scene));
  ASSERT_TRUE(detector.refine(image.view(), &found));
  const Errors errors = ErrorsOf(*found.pose, scene.markers[0]);
  EXPECT_LT(errors.position, 2e-4);
  EXPECT_LT(errors.rotation, 0.06);
}

// Nodes that are known to be hidden are left out, whatever is in their place.
TEST(PhotometricTest, UnknownBitsDoNotCount) {
  for (const InnerShape shape : {InnerShape::kSquare, InnerShape::kCircle}) {
    Scene scene = MakeScene(6, 30, SmallCamera(), 3);
    scene.markers[0].design.inner = shape;
    Image image = RenderScene(scene);
    const Detection clear = DetectOne(scene, image);
    Paint(&image, clear.vertices[9], 8, 120);
    Detection counted = clear, hidden = clear, unpainted = clear;
    hidden.unknown_bits = IdFromVertexBits(clear.family, uint64_t{1} << 9);
    unpainted.unknown_bits = hidden.unknown_bits;
    Detector detector(MakeOptions(scene));
    ASSERT_TRUE(detector.refine(image.view(), &counted));
    ASSERT_TRUE(detector.refine(image.view(), &hidden));
    ASSERT_TRUE(detector.refine(RenderScene(scene).view(), &unpainted));
    EXPECT_LT(hidden.pose->photometric->pixels, counted.pose->photometric->pixels - 50);
    EXPECT_LT(test::Distance(hidden.pose->t, unpainted.pose->t), 5e-6 * scene.markers[0].t[2]);
    const Errors errors = ErrorsOf(*hidden.pose, scene.markers[0]);
    EXPECT_LT(errors.position, 2e-4);
    EXPECT_LT(errors.rotation, 0.06);
  }
}

// A highlight, and the edge of a shadow across the marker.
TEST(PhotometricTest, UnevenLightIsBetterThanVerticesAlone) {
  const Scene scene = MakeScene(6, 30, SmallCamera(), 4);
  Image image = RenderScene(scene);
  const Point2 center = GroundTruth(scene, 0).center;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double side = x + 0.4 * y - center.x - 0.4 * center.y;
      const double light = 0.55 + 0.45 / (1 + std::exp(-side / 1.5));
      image.row(y)[x] = static_cast<uint8_t>(std::lround(image.row(y)[x] * light));
    }
  }
  const Detection found = DetectOne(scene, image);
  const Errors errors = ErrorsOf(*found.pose, scene.markers[0]);
  EXPECT_LT(errors.position, 1e-3);
  EXPECT_LT(errors.rotation, 0.3);
}

TEST(PhotometricTest, ForeignImagesAreRejected) {
  const Scene scene = MakeScene(6, 30, SmallCamera(), 5);
  const Image image = RenderScene(scene);
  Detector detector(MakeOptions(scene));
  const Detection found = DetectOne(scene, image);
  const auto is_kept = [&](const Image& other, Detection detection) {
    const Vector3 t = detection.pose->t;
    const Matrix6 covariance = detection.pose->covariance;
    return !detector.refine(other.view(), &detection) && detection.pose->t == t &&
           detection.pose->covariance == covariance;
  };
  Image flat(400, 400);
  EXPECT_TRUE(is_kept(flat, found));
  Scene elsewhere = scene;
  elsewhere.markers[0].R = test::RotationZ(0.5) * elsewhere.markers[0].R;
  EXPECT_TRUE(is_kept(RenderScene(elsewhere), found));
  Detection other_id = found;
  other_id.id ^= other_id.family.size() - 1;
  EXPECT_TRUE(is_kept(image, other_id));
  Detection no_pose = found;
  no_pose.pose.reset();
  EXPECT_FALSE(detector.refine(image.view(), &no_pose));
}

TEST(PhotometricTest, DecidesBetweenThePlanarSolutions) {
  int wrong_starts = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const Scene scene = MakeScene(2.6, 30, test::PinholeCamera(400, 400, 1500), seed);
    const Image image = RenderScene(scene);
    Options options = MakeOptions(scene);
    options.pose = PoseMode::kVertices;
    Detector detector(options);
    std::vector<Detection> found = detector.detect(image.view());
    if (found.size() != 1 || !found[0].pose || !found[0].pose->alternative) continue;
    // From the wrong one of the two, when it is a close call.
    Pose& pose = *found[0].pose;
    const PoseSolution vertices = pose;
    static_cast<PoseSolution&>(pose) = *pose.alternative;
    pose.alternative = vertices;
    pose.ambiguity = 1;
    wrong_starts += ErrorsOf(pose, scene.markers[0]).rotation > 20 ? 1 : 0;
    EXPECT_TRUE(detector.refine(image.view(), &found[0])) << seed;
    EXPECT_LT(ErrorsOf(*found[0].pose, scene.markers[0]).rotation, 5) << seed;
  }
  EXPECT_GE(wrong_starts, 8);
}

// Errors whitened by the reported covariance.
TEST(PhotometricTest, CovarianceDescribesTheScatter) {
  constexpr int kFrames = 60;
  for (const double tilt : {20.0, 55.0}) {
    Scene scene = MakeScene(5, tilt, SmallCamera(), 9);
    Detector detector(MakeOptions(scene));
    double ratio[3] = {};
    for (int i = 0; i < kFrames; ++i) {
      scene.seed = static_cast<uint64_t>(i);
      const std::vector<Detection> found = detector.detect(RenderScene(scene).view());
      ASSERT_EQ(found.size(), 1u);
      const Pose& pose = *found[0].pose;
      for (size_t k = 0; k < 3; ++k) {
        const double error = pose.t[k] - scene.markers[0].t[k];
        ratio[k] += error * error / pose.covariance[k + 3][k + 3] / kFrames;
        for (size_t j = 0; j < 6; ++j) EXPECT_EQ(pose.covariance[k][j], pose.covariance[j][k]);
      }
    }
    for (const double r : ratio) {
      EXPECT_GT(r, 0.5) << tilt;
      EXPECT_LT(r, 1.8) << tilt;
    }
  }
}

void ExpectSame(const Detection& a, const Detection& b) {
  ASSERT_TRUE(a.pose && b.pose);
  EXPECT_EQ(a.pose->t, b.pose->t);
  EXPECT_EQ(a.pose->R, b.pose->R);
  EXPECT_EQ(a.pose->rms_px, b.pose->rms_px);
  EXPECT_EQ(a.pose->covariance, b.pose->covariance);
  ASSERT_TRUE(a.pose->photometric && b.pose->photometric);
  EXPECT_EQ(a.pose->photometric->sigma, b.pose->photometric->sigma);
  EXPECT_EQ(a.pose->photometric->growth, b.pose->photometric->growth);
}

TEST(PhotometricTest, RoundNodesInARoundOutlineAreFittedWithoutIt) {
  const Errors errors = RmsErrors(8, 5, 35, SmallCamera(), [](Scene* scene) {
    scene->markers[0].design.inner = InnerShape::kCircle;
    scene->markers[0].design.outer = OuterShape::kCircle;
  });
  EXPECT_LT(errors.position, 1e-4);
  EXPECT_LT(errors.rotation, 0.03);
}

TEST(PhotometricTest, WithoutACameraThereIsNoPose) {
  const Scene scene = MakeScene(5, 30, SmallCamera(), 6);
  Options options = MakeOptions(scene);
  options.camera.reset();
  const std::vector<Detection> found = Detector(options).detect(RenderScene(scene).view());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].pose);
}

TEST(PhotometricTest, RefineIsTheOptionsStep) {
  const Scene scene = MakeScene(5, 30, SmallCamera(), 6);
  const Image image = RenderScene(scene);
  Options options = MakeOptions(scene);
  options.pose = PoseMode::kVertices;
  Detector detector(options);
  std::vector<Detection> found = detector.detect(image.view());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].pose->photometric);
  ASSERT_TRUE(detector.refine(image.view(), &found[0]));
  ExpectSame(found[0], DetectOne(scene, image));
}

TEST(PhotometricTest, ThreadsDoNotMatter) {
  Scene scene;
  scene.camera = test::PinholeCamera(640, 480, 700);
  test::Random random(1);
  for (int i = 0; i < 6; ++i) {
    SceneMarker marker;
    marker.design.id = random.Below(marker.design.family.size());
    marker.design.inner = static_cast<InnerShape>(i % 3);
    marker.R = random.Tilted(random.Uniform(0, 50) * kDegree);
    marker.t = {(i % 3 - 1) * 0.1, (i / 3 - 0.5) * 0.1, 0.5};
    scene.markers.push_back(marker);
  }
  const Image image = RenderScene(scene);
  Options options = MakeOptions(scene);
  const std::vector<Detection> one = Detector(options).detect(image.view());
  ASSERT_EQ(one.size(), 6u);
  for (const int threads : {2, 4}) {
    options.threads = threads;
    const std::vector<Detection> some = Detector(options).detect(image.view());
    ASSERT_EQ(some.size(), one.size());
    for (size_t i = 0; i < one.size(); ++i) ExpectSame(some[i], one[i]);
  }
}

// What the first of the targets gives.
const std::vector<Detection>& Reference(const std::vector<Scene>& scenes) {
  static const std::vector<Detection> reference = [&] {
    std::vector<Detection> found;
    ForcedTarget forced(SimdTargets().front());
    for (const Scene& scene : scenes) found.push_back(DetectOne(scene));
    return found;
  }();
  return reference;
}

class PhotometricTargetTest : public testing::TestWithParam<int64_t> {};

TOPOTAG_INSTANTIATE_SIMD_TEST(PhotometricTargetTest);

TEST_P(PhotometricTargetTest, GivesTheSamePoses) {
  std::vector<Scene> scenes;
  for (const InnerShape shape : {InnerShape::kSquare, InnerShape::kCircle, InnerShape::kHexagon}) {
    for (const double unit : {2.3, 5.0}) {
      scenes.push_back(MakeScene(unit, 40, SmallCamera(), scenes.size()));
      scenes.back().markers[0].design.inner = shape;
    }
  }
  scenes[3].markers[0].design.outer = OuterShape::kCircle;  // nodes and outline are round
  scenes[1].camera.model = DistortionModel::kBrown;
  scenes[1].camera.distortion[0] = -0.1;
  const std::vector<Detection>& reference = Reference(scenes);
  ForcedTarget forced(GetParam());
  for (size_t i = 0; i < scenes.size(); ++i) ExpectSame(DetectOne(scenes[i]), reference[i]);
}

}  // namespace
}  // namespace topotag
