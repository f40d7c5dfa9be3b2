#include <gtest/gtest.h>

#include <cmath>

#include "tests/scene_util.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

using test::kDegree;
using test::operator*;

Camera DistortedCamera() {
  Camera camera = test::PinholeCamera(640, 640, 500);
  camera.model = DistortionModel::kBrown;
  camera.distortion = {-0.25, 0.08, 0.001, -0.0005, -0.01};
  return camera;
}

Camera FisheyeCamera() {
  Camera camera = test::PinholeCamera(640, 640, 400);
  camera.model = DistortionModel::kFisheye;
  camera.distortion = {-0.01, 0.004, -0.003, 0.0005};
  return camera;
}

struct PoseErrors {
  double position = 0;  ///< of the distance
  double rotation = 0;  ///< degrees
  double vertex = 0;    ///< pixels
};

// Largest errors over random poses of noise-free renders.
PoseErrors LargestErrors(const Camera& camera, Family family, InnerShape shape, double pitch,
                         double max_tilt, double max_offset) {
  test::Random random(7);
  Options options;
  options.camera = camera;
  options.tag_size = 0.05;
  Detector detector(options);
  Scene scene;
  scene.camera = camera;
  scene.noise = 0;
  PoseErrors worst;
  for (int i = 0; i < 60; ++i) {
    SceneMarker marker;
    marker.design.family = family;
    marker.design.id = random.Below(family.size());
    marker.design.inner = shape;
    const double z = test::DistanceForPitch(camera, family, marker.tag_size, pitch);
    marker.t = {random.Uniform(-max_offset, max_offset) * z,
                random.Uniform(-max_offset, max_offset) * z, z};
    marker.R = random.Tilted(random.Uniform(0, max_tilt) * kDegree);
    scene.markers = {marker};
    const std::vector<Detection> found = detector.detect(RenderScene(scene).view());
    const Detection truth = GroundTruth(scene, 0);
    if (found.size() != 1 || found[0].id != marker.design.id || !found[0].pose) {
      ADD_FAILURE() << "case " << i << ": " << found.size() << " detections";
      continue;
    }
    worst.position =
        std::max(worst.position, test::Distance(found[0].pose->t, marker.t) / test::Norm(marker.t));
    worst.rotation = std::max(worst.rotation, test::AngleBetween(found[0].pose->R, marker.R));
    for (int v = 0; v < family.vertex_count(); ++v) {
      worst.vertex =
          std::max(worst.vertex, test::Distance(found[0].vertices[v], truth.vertices[v]));
    }
  }
  return worst;
}

class PoseAccuracyTest : public testing::TestWithParam<std::tuple<int, InnerShape>> {};

TEST_P(PoseAccuracyTest, NoiseFreeAtThirtyPixelsPitch) {
  const PoseErrors worst =
      LargestErrors(test::PinholeCamera(480, 480, 600), Family(std::get<0>(GetParam())),
                    std::get<1>(GetParam()), 30, 60, 0.05);
  RecordProperty("position_percent", std::to_string(100 * worst.position));
  RecordProperty("rotation_degrees", std::to_string(worst.rotation));
  EXPECT_LT(worst.position, 0.0005);
  EXPECT_LT(worst.rotation, 0.1);
  EXPECT_LT(worst.vertex, 0.06);
}

INSTANTIATE_TEST_SUITE_P(FamiliesAndShapes, PoseAccuracyTest,
                         testing::Combine(testing::Values(3, 4, 5),
                                          testing::Values(InnerShape::kSquare, InnerShape::kCircle,
                                                          InnerShape::kHexagon)),
                         [](const auto& info) {
                           return Family(std::get<0>(info.param)).name() + "_" +
                                  Name(std::get<1>(info.param));
                         });

TEST(PoseTest, LensDistortionIsPartOfTheModel) {
  const PoseErrors worst =
      LargestErrors(DistortedCamera(), Family(4), InnerShape::kSquare, 24, 45, 0.25);
  EXPECT_LT(worst.position, 0.0015);
  EXPECT_LT(worst.rotation, 0.2);
}

TEST(PoseTest, FisheyeLens) {
  const PoseErrors worst =
      LargestErrors(FisheyeCamera(), Family(4), InnerShape::kSquare, 24, 45, 0.4);
  EXPECT_LT(worst.position, 0.002);
  EXPECT_LT(worst.rotation, 0.3);
}

// A single marker with noise, many times: the errors, whitened by the reported covariance, have
// about unit variance.
TEST(PoseTest, CovarianceDescribesTheScatter) {
  Scene scene;
  scene.camera = test::PinholeCamera(400, 400, 600);
  scene.noise = 4;
  SceneMarker marker;
  marker.t = {0.01, -0.005, test::DistanceForPitch(scene.camera, Family(4), marker.tag_size, 24)};
  marker.R = test::RotationZ(0.4) * test::RotationX(35 * kDegree);
  scene.markers = {marker};
  Options options;
  options.camera = scene.camera;
  options.tag_size = marker.tag_size;
  Detector detector(options);

  constexpr int kFrames = 80;
  std::vector<Vector3> positions;
  double predicted[3] = {};
  Vector3 mean{};
  for (int i = 0; i < kFrames; ++i) {
    scene.seed = static_cast<uint64_t>(i);
    const std::vector<Detection> found = detector.detect(RenderScene(scene).view());
    ASSERT_EQ(found.size(), 1u);
    const Pose& pose = *found[0].pose;
    positions.push_back(pose.t);
    for (size_t k = 0; k < 3; ++k) {
      mean[k] += pose.t[k] / kFrames;
      predicted[k] += pose.covariance[k + 3][k + 3] / kFrames;
      for (size_t j = 0; j < 6; ++j) EXPECT_EQ(pose.covariance[k][j], pose.covariance[j][k]);
    }
  }
  for (size_t k = 0; k < 3; ++k) {
    double scatter = 0;
    for (const Vector3& t : positions) scatter += (t[k] - mean[k]) * (t[k] - mean[k]) / kFrames;
    // Never too small by much; a systematic part of the residuals may make it too large.
    EXPECT_GT(predicted[k], scatter / 2) << "axis " << k;
    EXPECT_LT(predicted[k], scatter * 8) << "axis " << k;
  }
}

TEST(PoseTest, AmbiguousViewsReportTheOtherSolution) {
  Scene scene;
  scene.camera = test::PinholeCamera(400, 400, 1200);
  SceneMarker marker;
  marker.t = {0, 0, test::DistanceForPitch(scene.camera, Family(4), marker.tag_size, 14)};
  marker.R = test::RotationX(40 * kDegree);
  scene.markers = {marker};
  Options options;
  options.camera = scene.camera;
  options.tag_size = marker.tag_size;
  const std::vector<Detection> found = Detector(options).detect(RenderScene(scene).view());
  ASSERT_EQ(found.size(), 1u);
  ASSERT_TRUE(found[0].pose->alternative);
  EXPECT_LT(test::AngleBetween(found[0].pose->R, marker.R), 3);
  EXPECT_LE(found[0].pose->rms_px, found[0].pose->alternative->rms_px);
  // The other solution is tilted the other way.
  EXPECT_LT(found[0].pose->alternative->R[2][1] * marker.R[2][1], 0);
}

TEST(PoseTest, TagSizeOfIdBeforeFamilyBeforeDefault) {
  Scene scene;
  scene.camera = test::PinholeCamera(400, 400, 600);
  SceneMarker marker;
  marker.design.id = 77;
  marker.t = {0, 0, 0.2};
  scene.markers = {marker};
  const Image image = RenderScene(scene);
  Options options;
  options.camera = scene.camera;
  const auto depth = [&] {
    const std::vector<Detection> found = Detector(options).detect(image.view());
    return found.size() == 1 && found[0].pose ? found[0].pose->t[2] : 0;
  };
  EXPECT_EQ(depth(), 0);  // no size, no pose
  options.tag_size = 0.05;
  EXPECT_NEAR(depth(), 0.2, 0.0005);
  options.family_tag_size[4] = 0.1;
  EXPECT_NEAR(depth(), 0.4, 0.001);
  options.id_tag_size[{4, 77}] = 0.025;
  EXPECT_NEAR(depth(), 0.1, 0.0003);
  options.id_tag_size[{4, 77}] = 0;
  EXPECT_EQ(depth(), 0);
}

}  // namespace
}  // namespace topotag
