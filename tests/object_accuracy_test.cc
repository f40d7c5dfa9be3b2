// The pose of a rendered rhombicuboctahedron with 18 markers over a full turn, beside that of the
// best single marker in view.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host/cholesky.h"
#include "host/rigid_transform.h"
#include "tests/object_util.h"
#include "topotag/detector.h"
#include "topotag/object.h"

namespace topotag {
namespace {

constexpr int kSteps = 36;
constexpr double kEdge = 0.04, kTagSize = 0.03;  // metres

using test::ObjectPlace;

double Trace(const Matrix6& covariance) {
  return covariance[3][3] + covariance[4][4] + covariance[5][5];
}

// Errors of the object's origin, sums of squares over the turn, metres^2.
struct TurnErrors {
  double object = 0;
  double best = 0;      ///< by the marker with the smallest position covariance
  double nearest = 0;   ///< by the marker that happens to be most right
  double whitened = 0;  ///< of the object's pose: squares of the six errors in standard deviations
  double used = 0, rejected = 0;
};

class Turn {
 public:
  Turn(PoseMode mode, double distance) : distance_(distance) {
    scene_.camera = test::PinholeCamera(640, 480, 695);
    options_.camera = scene_.camera;
    options_.families = {Family(4)};
    options_.tag_size = kTagSize;
    options_.pose = mode;
  }

  TurnErrors Run(size_t hide) {
    Detector detector(options_);
    ObjectPoseEstimator estimator(body_, scene_.camera);
    TurnErrors errors;
    for (int step = 0; step < kSteps; ++step) {
      ObjectPlace place;
      const Matrix3 turned = test::RotationY(2 * M_PI * step / kSteps + 0.01);
      place.R = topotag::operator*(test::RotationX(0.35), turned);
      place.t = {0.02, -0.01, distance_};
      scene_.markers = test::VisibleMarkers(body_, place, hide, static_cast<size_t>(step));
      scene_.seed = static_cast<uint64_t>(step) + 1;
      const std::vector<Detection> found = detector.detect(RenderScene(scene_).view());
      ObjectPose pose;
      if (!estimator.estimate(found, &pose)) {
        ADD_FAILURE() << "no pose in step " << step;
        continue;
      }
      Add(place, found, pose, &errors);
    }
    return errors;
  }

 private:
  // Of the object's origin, by one marker alone.
  double SingleError(const Detection& detection, const ObjectPlace& place) const {
    const ObjectMarker& marker = body_.markers[detection.id];
    const RigidTransform seen{detection.pose->R, detection.pose->t};
    const RigidTransform pose = seen * RigidTransform{marker.R, marker.t}.Inverse();
    return test::Distance(pose.t, place.t);
  }

  void Add(const ObjectPlace& place, const std::vector<Detection>& found, const ObjectPose& pose,
           TurnErrors* errors) const {
    const Detection* best = &found[0];
    double nearest = INFINITY;
    for (const Detection& detection : found) {
      if (Trace(detection.pose->covariance) < Trace(best->pose->covariance)) best = &detection;
      nearest = std::min(nearest, SingleError(detection, place));
    }
    const double object = test::Distance(pose.t, place.t);
    errors->object += object * object;
    errors->best += SingleError(*best, place) * SingleError(*best, place);
    errors->nearest += nearest * nearest;
    errors->used += static_cast<double>(pose.used.size());
    errors->rejected += static_cast<double>(pose.rejected.size());
    const Vector3 w = RotationVector(topotag::operator*(pose.R, Transposed(place.R)));
    const Vector3 dt = pose.t - place.t;
    const double error[6] = {w[0], w[1], w[2], dt[0], dt[1], dt[2]};
    double solved[6];
    std::copy(error, error + 6, solved);
    Matrix6 factor = pose.covariance;
    ASSERT_TRUE(Factorize(factor[0].data(), 6));
    SolveFactorized(factor[0].data(), 6, solved);
    for (int k = 0; k < 6; ++k) errors->whitened += error[k] * solved[k];
  }

  const Object body_ = MakeRhombicuboctahedron(Family(4), 0, kTagSize, kEdge);
  double distance_;
  Scene scene_;
  Options options_;
};

double Millimetres(double squares) { return 1e3 * std::sqrt(squares / kSteps); }

void Record(const TurnErrors& errors) {
  testing::Test::RecordProperty("object_mm", std::to_string(Millimetres(errors.object)));
  testing::Test::RecordProperty("best_marker_mm", std::to_string(Millimetres(errors.best)));
  testing::Test::RecordProperty("nearest_marker_mm", std::to_string(Millimetres(errors.nearest)));
  testing::Test::RecordProperty("whitened", std::to_string(errors.whitened / kSteps));
  testing::Test::RecordProperty("markers", std::to_string(errors.used / kSteps));
}

class PhotometricTurnTest : public testing::TestWithParam<double> {};

// Half the error of the best single marker, even of the one that happens to be most right.
TEST_P(PhotometricTurnTest, ObjectBeatsSingleMarkers) {
  for (const size_t hide : {0, 3}) {
    SCOPED_TRACE(hide == 0 ? "all markers" : "a third hidden");
    const TurnErrors errors = Turn(PoseMode::kPhotometric, GetParam()).Run(hide);
    Record(errors);
    EXPECT_LE(errors.object, 0.5 * 0.5 * errors.best);
    EXPECT_LE(errors.object, 0.7 * 0.7 * errors.nearest);
    EXPECT_LT(Millimetres(errors.object), 1e-4 * GetParam() * 1e3);
    EXPECT_EQ(errors.rejected, 0);
    // Of six expected.
    EXPECT_GT(errors.whitened / kSteps, 3);
    EXPECT_LT(errors.whitened / kSteps, 10);
  }
}

INSTANTIATE_TEST_SUITE_P(Distances, PhotometricTurnTest, testing::Values(0.25, 0.4),
                         [](const auto& info) {
                           return std::to_string(std::lround(100 * info.param)) + "cm";
                         });

// Vertices have systematic errors that all markers of a frame share: less is gained.
TEST(VerticesTurnTest, ObjectBeatsSingleMarkers) {
  for (const double distance : {0.3, 0.5}) {
    SCOPED_TRACE(distance);
    const TurnErrors all = Turn(PoseMode::kVertices, distance).Run(0);
    Record(all);
    EXPECT_LE(all.object, 0.35 * 0.35 * all.best);
    EXPECT_EQ(all.rejected, 0);
    const TurnErrors hidden = Turn(PoseMode::kVertices, distance).Run(3);
    EXPECT_LE(hidden.object, 0.5 * 0.5 * hidden.best);
    EXPECT_EQ(hidden.rejected, 0);
    for (const TurnErrors& errors : {all, hidden}) {
      // Of six expected: what blur may do to vertices is allowed for.
      EXPECT_GT(errors.whitened / kSteps, 1);
      EXPECT_LT(errors.whitened / kSteps, 8);
    }
  }
}

}  // namespace
}  // namespace topotag
