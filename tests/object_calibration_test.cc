#include "topotag/object_calibration.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/object_util.h"
#include "topotag/detector.h"
#include "topotag/error.h"

namespace topotag {
namespace {

using test::ObjectPlace;
using test::operator*;

// As glued together by hand: every marker off by up to 1 mm and some degrees.
Object HandMade(const Object& object, test::Random* random) {
  Object result = object;
  for (ObjectMarker& marker : result.markers) {
    const double x = random->Uniform(-0.03, 0.03), z = random->Uniform(-0.05, 0.05);
    marker.R = test::RotationZ(z) * (test::RotationX(x) * marker.R);
    for (double& value : marker.t) value += random->Uniform(-0.001, 0.001);
  }
  return result;
}

struct Errors {
  double position = 0;  ///< largest, millimetres
  double rotation = 0;  ///< largest, degrees
};

Errors Compare(const Object& a, const Object& b) {
  Errors errors;
  for (size_t i = 0; i < a.markers.size(); ++i) {
    errors.position =
        std::max(errors.position, 1e3 * test::Distance(a.markers[i].t, b.markers[i].t));
    errors.rotation = std::max(errors.rotation, test::AngleBetween(a.markers[i].R, b.markers[i].R));
  }
  return errors;
}

class ObjectCalibrationTest : public testing::Test {
 protected:
  ObjectCalibrationTest() {
    scene_.camera = test::PinholeCamera(640, 480, 695);
    real_ = HandMade(ideal_, &random_);
    // What is known beforehand: the first marker's frame.
    start_ = ideal_;
    for (ObjectMarker& marker : start_.markers) marker = Unplaced(marker);
    start_.markers[0] = real_.markers[0];
  }

  static ObjectMarker Unplaced(const ObjectMarker& marker) {
    ObjectMarker result;
    result.family = marker.family;
    result.id = marker.id;
    result.tag_size = marker.tag_size;
    return result;
  }

  // Sets the scene to a view from anywhere.
  void Turn(double distance, uint64_t seed) {
    ObjectPlace place;
    place.R = random_.Tilted(random_.Uniform(0, M_PI));
    place.t = {random_.Uniform(-0.1, 0.1) * distance, random_.Uniform(-0.1, 0.1) * distance,
               random_.Uniform(0.9, 1.15) * distance};
    scene_.markers = test::VisibleMarkers(real_, place);
    scene_.seed = seed;
  }

  std::vector<ObjectView> ExactViews(int count) {
    std::vector<ObjectView> views;
    for (int i = 0; i < count; ++i) {
      Turn(0.4, 1);
      views.push_back({scene_.camera, test::ExactDetections(scene_)});
    }
    return views;
  }

  std::vector<ObjectView> RenderedViews(int count, double distance, PoseMode mode) {
    Options options;
    options.camera = scene_.camera;
    options.families = {Family(4)};
    options.tag_size = 0.03;
    options.pose = mode;
    Detector detector(options);
    std::vector<ObjectView> views;
    for (int i = 0; i < count; ++i) {
      Turn(distance, static_cast<uint64_t>(i) + 1);
      views.push_back({scene_.camera, detector.detect(RenderScene(scene_).view())});
    }
    return views;
  }

  std::string Complaint(const std::vector<ObjectView>& views) const {
    try {
      CalibrateObject(start_, views);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      return error.what();
    }
    return "nothing";
  }

  const Object ideal_ = MakeRhombicuboctahedron(Family(4), 0, 0.03, 0.04);
  test::Random random_{6};
  Object real_, start_;
  Scene scene_;
};

TEST_F(ObjectCalibrationTest, ExactViewsGiveTheExactObject) {
  const ObjectCalibration result = CalibrateObject(start_, ExactViews(30));
  const Errors errors = Compare(result.object, real_);
  EXPECT_LT(errors.position, 1e-5);
  EXPECT_LT(errors.rotation, 1e-4);
  EXPECT_LT(result.rms_px, 1e-5);
  EXPECT_EQ(result.views, 30);
  EXPECT_EQ(result.rejected, 0);
  EXPECT_EQ(result.object.markers[0].t, start_.markers[0].t);
}

TEST_F(ObjectCalibrationTest, FortyRenderedViews) {
  const std::vector<ObjectView> views = RenderedViews(40, 0.4, PoseMode::kPhotometric);
  const auto begin = std::chrono::steady_clock::now();
  const ObjectCalibration result = CalibrateObject(start_, views);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  const Errors errors = Compare(result.object, real_);
  RecordProperty("position_mm", std::to_string(errors.position));
  RecordProperty("rotation_degrees", std::to_string(errors.rotation));
  RecordProperty("seconds", std::to_string(seconds.count()));
  EXPECT_LT(errors.position, 0.02);
  EXPECT_LT(errors.rotation, 0.015);
  EXPECT_LT(seconds.count(), 5);
  EXPECT_EQ(result.views, 40);
  // Steep markers may be off by more than their covariance says.
  EXPECT_LT(result.rejected, 20);
  for (size_t i = 1; i < real_.markers.size(); ++i) {
    EXPECT_GE(result.sightings[i], 3);
    const Matrix6& covariance = result.covariance[i];
    const double sigma = std::sqrt(covariance[3][3] + covariance[4][4] + covariance[5][5]);
    EXPECT_LT(test::Distance(result.object.markers[i].t, real_.markers[i].t), 4 * sigma);
    EXPECT_LT(sigma, 5e-5);
  }
  EXPECT_EQ(result.covariance[0], Matrix6{});
}

TEST_F(ObjectCalibrationTest, FortyRenderedViewsByVerticesAlone) {
  const ObjectCalibration result =
      CalibrateObject(start_, RenderedViews(40, 0.3, PoseMode::kVertices));
  const Errors errors = Compare(result.object, real_);
  RecordProperty("position_mm", std::to_string(errors.position));
  RecordProperty("rotation_degrees", std::to_string(errors.rotation));
  EXPECT_LT(errors.position, 0.05);
  EXPECT_LT(errors.rotation, 0.02);
}

// Moved so that the markers lie as near as can be to where they are meant to be: turning the truth
// in the same way gives the same object.
TEST_F(ObjectCalibrationTest, FrameOfAllMarkers) {
  std::vector<ObjectView> views = ExactViews(30);
  const ObjectCalibration exact = CalibrateObject(ideal_, views, ObjectFrame::kAllMarkers);
  EXPECT_LT(Compare(exact.object, ideal_).position, 3);
  for (ObjectView& view : views) test::Disturb(0.02, &random_, &view.detections);
  const ObjectCalibration result = CalibrateObject(ideal_, views, ObjectFrame::kAllMarkers);
  double whitened = 0;
  for (size_t i = 0; i < real_.markers.size(); ++i) {
    const Vector3& t = result.object.markers[i].t;
    const Vector3& expected = exact.object.markers[i].t;
    for (size_t k = 0; k < 3; ++k) {
      whitened +=
          (t[k] - expected[k]) * (t[k] - expected[k]) / result.covariance[i][k + 3][k + 3] / 54;
    }
  }
  EXPECT_GT(whitened, 0.1);
  EXPECT_LT(whitened, 2.5);
}

TEST_F(ObjectCalibrationTest, WrongSightingsAreRejected) {
  std::vector<ObjectView> views = ExactViews(30);
  int wrong = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    std::vector<Detection>& detections = views[i].detections;
    test::Disturb(0.02, &random_, &detections);
    if (i % 3 != 0 || detections.size() < 6) continue;
    const size_t first = random_.Below(5);
    std::swap(detections[first].id, detections[first + 1].id);
    wrong += 2;
    // Twice in view: it cannot be told which one is the object's.
    detections.push_back(detections[(first + 2) % 6]);
  }
  ASSERT_GE(wrong, 10);
  const ObjectCalibration result = CalibrateObject(start_, views);
  const Errors errors = Compare(result.object, real_);
  EXPECT_LT(errors.position, 0.05);
  EXPECT_LT(errors.rotation, 0.1);
  EXPECT_EQ(result.rejected, wrong);
}

TEST_F(ObjectCalibrationTest, MarkersThatAreNotSeenAreNamed) {
  EXPECT_EQ(Complaint({}), "there is no view of the object");
  EXPECT_EQ(Complaint({{scene_.camera, {}}}), "marker 4x4 0 is in no view");
  std::vector<ObjectView> views = ExactViews(30);
  const auto is_last = [](const Detection& d) { return d.id == 17; };
  std::vector<ObjectView> without = views, alone = views;
  for (size_t i = 0; i < views.size(); ++i) {
    std::vector<Detection>& a = without[i].detections;
    a.erase(std::remove_if(a.begin(), a.end(), is_last), a.end());
    std::vector<Detection>& b = alone[i].detections;
    if (std::any_of(b.begin(), b.end(), is_last)) {
      b.erase(std::remove_if(b.begin(), b.end(), std::not_fn(is_last)), b.end());
    }
  }
  EXPECT_EQ(Complaint(without), "marker 4x4 17 is in no view");
  EXPECT_EQ(Complaint(alone),
            "marker 4x4 17 is in no view together with marker 4x4 0 or what is joined to it");
  start_.markers.resize(1);
  EXPECT_EQ(Complaint(views), "the object has one marker: there is nothing to measure");
}

// What the views say of two markers is kept for the pairs that they show, not for all there are.
TEST_F(ObjectCalibrationTest, ManyMarkersThatAreSeenAlone) {
  constexpr uint64_t kMarkers = 3000;
  const auto most_megabytes = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss / 1024;
  };
  Object room;
  std::vector<ObjectView> views;
  const ObjectView any = ExactViews(1)[0];
  for (uint64_t i = 0; i < kMarkers; ++i) {
    ObjectMarker marker = Unplaced(start_.markers[0]);
    marker.id = i;
    room.markers.push_back(marker);
    views.push_back({any.camera, {any.detections[0]}});
    views.back().detections[0].id = i;
  }
  start_ = room;
  const long before = most_megabytes();
  EXPECT_EQ(Complaint(views),
            "marker 4x4 1 is in no view together with marker 4x4 0 or what is joined to it");
  EXPECT_LT(most_megabytes() - before, 200);
}

}  // namespace
}  // namespace topotag
