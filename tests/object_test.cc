#include "topotag/object.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tests/object_util.h"
#include "topotag/error.h"

namespace topotag {
namespace {

using test::ObjectPlace;
using test::operator*;

std::string Complaint(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "nothing";
}

TEST(ObjectTest, GridIsCentredAndNumberedByRows) {
  const Object board = MakeGrid(Family(3), 10, 2, 3, 0.02, 0.05);
  ASSERT_EQ(board.markers.size(), 6u);
  EXPECT_EQ(board.markers[0].id, 10u);
  EXPECT_EQ(board.markers[5].id, 15u);
  EXPECT_NEAR(board.markers[0].t[0], -0.05, 1e-15);
  EXPECT_NEAR(board.markers[0].t[1], -0.025, 1e-15);
  EXPECT_NEAR(board.markers[1].t[0], 0, 1e-15);
  EXPECT_NEAR(board.markers[5].t[0], 0.05, 1e-15);
  EXPECT_NEAR(board.markers[5].t[1], 0.025, 1e-15);
  EXPECT_EQ(board.markers[4].tag_size, 0.02);
  ValidateObject(board);
}

// The corner (x, y) of a face with sides of 2, object's frame.
Vector3 FaceCorner(const ObjectMarker& face, double half, int x, int y) {
  const Vector3 arm = test::Rotated(face.R, {x * half, y * half, 0});
  return {face.t[0] + arm[0], face.t[1] + arm[1], face.t[2] + arm[2]};
}

TEST(ObjectTest, RhombicuboctahedronHasClosedOutwardFaces) {
  const double edge = 0.04;
  const Object body = MakeRhombicuboctahedron(Family(4), 100, 0.03, edge);
  ValidateObject(body);
  ASSERT_EQ(body.markers.size(), 18u);
  std::set<uint64_t> ids;
  for (const ObjectMarker& face : body.markers) {
    ids.insert(face.id);
    EXPECT_NEAR(test::Norm(face.t), edge * (1 + std::sqrt(2)) / 2, 1e-12);
    // The tag's z axis points to the centre.
    const Vector3 inwards = test::Rotated(face.R, {0, 0, test::Norm(face.t)});
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(inwards[k], -face.t[k], 1e-12);
  }
  EXPECT_EQ(*ids.begin(), 100u);
  EXPECT_EQ(*ids.rbegin(), 117u);
  // Every square's corner is one of 24 vertices, and each of these belongs to three squares.
  std::vector<Vector3> corners;
  for (const ObjectMarker& face : body.markers) {
    for (const int x : {-1, 1}) {
      for (const int y : {-1, 1}) corners.push_back(FaceCorner(face, edge / 2, x, y));
    }
  }
  for (const Vector3& corner : corners) {
    EXPECT_EQ(std::count_if(corners.begin(), corners.end(),
                            [&](const Vector3& c) { return test::Distance(c, corner) < 1e-12; }),
              3);
  }
  // The third face of the belt looks along +x, the first ones of the rings up and down, at -z.
  EXPECT_GT(body.markers[2].t[0], 0.99 * test::Norm(body.markers[2].t));
  EXPECT_LT(body.markers[8].t[1], -0.02);
  EXPECT_LT(body.markers[8].t[2], -0.02);
  EXPECT_GT(body.markers[12].t[1], 0.02);
  EXPECT_LT(body.markers[16].t[1], -0.04);
  EXPECT_GT(body.markers[17].t[1], 0.04);
}

TEST(ObjectTest, GeneratorsNameWhatIsWrong) {
  EXPECT_NE(Complaint([] { MakeGrid(Family(3), 120, 3, 3, 0.02, 0.03); }).find("9 IDs from 120"),
            std::string::npos);
  EXPECT_NE(Complaint([] { MakeGrid(Family(3), 0, 0, 3, 0.02, 0.03); }).find("rows 0"),
            std::string::npos);
  EXPECT_NE(Complaint([] { MakeGrid(Family(3), 0, 2, 2, 0.02, 0.019); }).find("pitch 0.019 m"),
            std::string::npos);
  EXPECT_NE(Complaint([] { MakeGrid(Family(3), 0, 2, 2, -1, 0.019); }).find("tag size -1 m"),
            std::string::npos);
  EXPECT_NE(Complaint([] { MakeRhombicuboctahedron(Family(4), 0, 0.03, 0.02); }).find("edge 0.02"),
            std::string::npos);
}

TEST(ObjectTest, ValidateNamesTheMarker) {
  const auto complaint = [](const std::function<void(ObjectMarker*)>& spoil) {
    Object board = MakeGrid(Family(4), 0, 2, 2, 0.03, 0.05);
    spoil(&board.markers[2]);
    return Complaint([&] { ValidateObject(board); });
  };
  EXPECT_EQ(complaint([](ObjectMarker*) {}), "nothing");
  EXPECT_EQ(complaint([](ObjectMarker* m) { m->id = 16384; }),
            "marker 4x4 16384: the ID is outside the range 0 .. 16383 of 4x4");
  EXPECT_EQ(complaint([](ObjectMarker* m) { m->id = 1; }), "marker 4x4 1 occurs twice");
  EXPECT_EQ(complaint([](ObjectMarker* m) { m->tag_size = 0; }),
            "marker 4x4 2: the size 0 m is not within 1e-09 .. 1e+06");
  EXPECT_NE(complaint([](ObjectMarker* m) { m->t[1] = NAN; }).find("marker 4x4 2: the position"),
            std::string::npos);
  EXPECT_EQ(complaint([](ObjectMarker* m) { m->R[0][0] = -1; }),
            "marker 4x4 2: R is not a rotation matrix");
  EXPECT_EQ(complaint([](ObjectMarker* m) { m->R[2][2] = NAN; }),
            "marker 4x4 2: R is not a rotation matrix");
  EXPECT_EQ(Complaint([] { ValidateObject({}); }), "the object has no marker");
}

class ObjectPoseTest : public testing::Test {
 protected:
  ObjectPoseTest() {
    scene_.camera = test::PinholeCamera(1280, 960, 695);
    place_.R = test::RotationX(0.35) * test::RotationY(0.2);
    place_.t = {0.02, -0.01, 0.4};
    scene_.markers = test::VisibleMarkers(body_, place_);
  }

  ObjectPose Estimate(const std::vector<Detection>& detections) const {
    ObjectPoseEstimator estimator(body_, scene_.camera);
    ObjectPose pose;
    EXPECT_TRUE(estimator.estimate(detections, &pose));
    return pose;
  }
  void ExpectExact(const ObjectPose& pose, double tolerance = 1e-8) const {
    EXPECT_LT(test::Distance(pose.t, place_.t), tolerance);
    EXPECT_LT(test::AngleBetween(pose.R, place_.R), 1e3 * tolerance);
  }

  Object body_ = MakeRhombicuboctahedron(Family(4), 0, 0.03, 0.04);
  ObjectPlace place_;
  Scene scene_;
};

TEST_F(ObjectPoseTest, ExactVerticesGiveTheExactPose) {
  const std::vector<Detection> detections = test::ExactDetections(scene_);
  const ObjectPose pose = Estimate(detections);
  ExpectExact(pose);
  EXPECT_LT(pose.rms_px, 1e-6);
  EXPECT_EQ(pose.used.size(), detections.size());
  EXPECT_TRUE(pose.rejected.empty());
  EXPECT_FALSE(pose.alternative);
}

TEST_F(ObjectPoseTest, LensDistortionIsPartOfTheModel) {
  scene_.camera.model = DistortionModel::kBrown;
  scene_.camera.distortion = {-0.25, 0.08, 0.001, -0.0005, -0.01};
  ExpectExact(Estimate(test::ExactDetections(scene_)));
  scene_.camera.model = DistortionModel::kFisheye;
  scene_.camera.distortion = {-0.01, 0.004, -0.003, 0.0005};
  ExpectExact(Estimate(test::ExactDetections(scene_)));
}

TEST_F(ObjectPoseTest, StrangeMarkersAndNoMarkersGiveNoPose) {
  ObjectPoseEstimator estimator(body_, scene_.camera);
  ObjectPose pose;
  pose.t[0] = 77;
  EXPECT_FALSE(estimator.estimate({}, &pose));
  std::vector<Detection> detections = test::ExactDetections(scene_);
  for (Detection& detection : detections) detection.id += 100;
  EXPECT_FALSE(estimator.estimate(detections, &pose));
  EXPECT_EQ(pose.t[0], 77);
}

// One that is misread as another of the object, a second one with the same ID, and one that has
// moved by half a millimetre.
TEST_F(ObjectPoseTest, MarkersThatContradictTheOthersAreLeftOut) {
  SceneMarker moved = scene_.markers[1];
  moved.t[0] += 0.0005;
  Scene scene = scene_;
  scene.markers[1] = moved;
  SceneMarker second = scene_.markers[2];
  second.t = {-0.15, 0.1, 0.3};
  scene.markers.push_back(second);
  std::vector<Detection> detections = test::ExactDetections(scene);
  test::Random random(3);
  test::Disturb(0.01, &random, &detections);
  detections[0].id = 17;  // the bottom, out of sight
  const ObjectPose pose = Estimate(detections);
  const ObjectPose of_others =
      Estimate(std::vector<Detection>(detections.begin() + 2, detections.end() - 1));
  EXPECT_EQ(pose.used.size(), of_others.used.size());
  EXPECT_LT(test::Distance(pose.t, of_others.t), 1e-8);
  EXPECT_LT(test::Distance(pose.t, place_.t), 1e-4);
  EXPECT_EQ(pose.rejected, (std::vector<int>{0, 1, static_cast<int>(detections.size()) - 1}));
  EXPECT_EQ(pose.used.size() + pose.rejected.size(), detections.size());
}

TEST_F(ObjectPoseTest, WrongMarkersMayBeLargerAndHalfOfAll) {
  std::vector<Detection> detections = test::ExactDetections(scene_);
  ASSERT_GE(detections.size(), 6u);
  detections.resize(6);
  for (size_t i = 0; i < 3; ++i) {
    // Each somewhere else, and nearer.
    SceneMarker wrong = scene_.markers[i];
    wrong.R = test::RotationZ(static_cast<double>(i)) * test::RotationX(0.3);
    wrong.t = {0.08 * (static_cast<double>(i) - 1), 0.08, 0.2};
    Scene scene = scene_;
    scene.markers = {wrong};
    detections[i] = test::ExactDetections(scene)[0];
  }
  const ObjectPose pose = Estimate(detections);
  ExpectExact(pose);
  EXPECT_EQ(pose.rejected, (std::vector<int>{0, 1, 2}));
}

TEST_F(ObjectPoseTest, OneMarkerIsEnoughAndReportsTheOtherSolution) {
  scene_.camera = test::PinholeCamera(1280, 960, 1800);
  place_.R = test::RotationX(0.6);
  place_.t = {0, 0, 1.5};
  scene_.markers = {test::Placed(body_.markers[0], place_)};
  const ObjectPose pose = Estimate(test::ExactDetections(scene_));
  ExpectExact(pose, 1e-6);
  ASSERT_TRUE(pose.alternative);
  EXPECT_GT(test::AngleBetween(pose.alternative->R, pose.R), 20);
  EXPECT_GT(pose.alternative->rms_px, pose.rms_px);
}

TEST_F(ObjectPoseTest, FarBoardsReportTheOtherSolutionToo) {
  body_ = MakeGrid(Family(4), 0, 2, 3, 0.03, 0.04);
  place_.R = test::RotationX(0.6);
  place_.t = {0, 0, 3};
  scene_.camera = test::PinholeCamera(1280, 960, 3000);
  scene_.markers = test::VisibleMarkers(body_, place_);
  ASSERT_EQ(scene_.markers.size(), 6u);
  const ObjectPose pose = Estimate(test::ExactDetections(scene_));
  ExpectExact(pose, 1e-6);
  ASSERT_TRUE(pose.alternative);
  EXPECT_GT(test::AngleBetween(pose.alternative->R, pose.R), 20);
}

TEST_F(ObjectPoseTest, MixedFamiliesAndSizes) {
  body_.markers[0].family = Family(3);
  body_.markers[0].tag_size = 0.02;
  body_.markers[1].family = Family(6);
  scene_.markers = test::VisibleMarkers(body_, place_);
  ExpectExact(Estimate(test::ExactDetections(scene_)));
}

TEST_F(ObjectPoseTest, TheOrderOfDetectionsDoesNotMatter) {
  std::vector<Detection> detections = test::ExactDetections(scene_);
  test::Random random(4);
  test::Disturb(0.05, &random, &detections);
  const ObjectPose pose = Estimate(detections);
  std::reverse(detections.begin(), detections.end());
  const ObjectPose other = Estimate(detections);
  EXPECT_EQ(pose.t, other.t);
  EXPECT_EQ(pose.R, other.R);
  EXPECT_EQ(pose.covariance, other.covariance);
}

// Never too small; the systematic errors that it allows for are not in this scatter.
TEST_F(ObjectPoseTest, CovarianceDescribesTheScatter) {
  test::Random random(5);
  const std::vector<Detection> exact = test::ExactDetections(scene_);
  constexpr int kFrames = 200;
  Vector3 squares{}, predicted{};
  for (int i = 0; i < kFrames; ++i) {
    std::vector<Detection> detections = exact;
    test::Disturb(0.1, &random, &detections);
    const ObjectPose pose = Estimate(detections);
    for (size_t k = 0; k < 3; ++k) {
      squares[k] += (pose.t[k] - place_.t[k]) * (pose.t[k] - place_.t[k]) / kFrames;
      predicted[k] += pose.covariance[k + 3][k + 3] / kFrames;
      for (size_t j = 0; j < 6; ++j) EXPECT_EQ(pose.covariance[k][j], pose.covariance[j][k]);
    }
  }
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_GT(predicted[k], 0.7 * squares[k]) << "axis " << k;
    EXPECT_LT(predicted[k], 4 * squares[k]) << "axis " << k;
  }
}

}  // namespace
}  // namespace topotag
