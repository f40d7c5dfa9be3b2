// What a caller may get wrong with markers, scenes, cameras and objects; as misuse_test.

#include <gtest/gtest.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/misuse_util.h"
#include "tests/object_util.h"
#include "topotag/object_calibration.h"

namespace topotag {
namespace {

Scene OneMarker() {
  Scene scene;
  scene.camera = test::PinholeCamera(64, 48, 100);
  scene.markers.emplace_back();
  scene.markers[0].t = {0, 0, 0.3};
  return scene;
}

void ExpectSceneRefused(const std::string& part, const std::function<void(Scene*)>& change) {
  Scene scene = OneMarker();
  change(&scene);
  ExpectRefused(part, [&] { RenderScene(scene); });
  ExpectRefused(part, [&] { GroundTruth(scene, 0); });
}

TEST(MisuseOfScenesTest, Markers) {
  for (const double value : kNotPositive) {
    ExpectSceneRefused("tag size", [&](Scene* s) { s->markers[0].tag_size = value; });
    ExpectSceneRefused("marker 0", [&](Scene* s) { s->markers[0].t[2] = value; });
  }
  for (const double value : kNotFinite) {
    ExpectSceneRefused("translation", [&](Scene* s) { s->markers[0].t[0] = value; });
    ExpectSceneRefused("R", [&](Scene* s) { s->markers[0].R[1][1] = value; });
    ExpectSceneRefused("black", [&](Scene* s) { s->markers[0].black = value; });
    ExpectSceneRefused("white", [&](Scene* s) { s->markers[0].white = value; });
    ExpectSceneRefused("growth", [&](Scene* s) { s->markers[0].growth = value; });
    ExpectSceneRefused("velocity", [&](Scene* s) { s->markers[0].velocity[2] = value; });
    ExpectSceneRefused("angular", [&](Scene* s) { s->markers[0].angular_velocity[1] = value; });
    ExpectSceneRefused("frame width", [&](Scene* s) { s->markers[0].design.frame = value; });
    ExpectSceneRefused("margin width", [&](Scene* s) { s->markers[0].design.margin = value; });
  }
  ExpectSceneRefused("ID", [](Scene* s) { s->markers[0].design.id = UINT64_MAX; });
  ExpectSceneRefused("ID 1000", [](Scene* s) {
    s->markers[0].design.family = Family(3);
    s->markers[0].design.id = 1000;
  });
  ExpectSceneRefused("growth 5", [](Scene* s) { s->markers[0].growth = 5; });
  Scene fast = OneMarker();
  fast.exposure = 1;
  fast.markers[0].velocity = {1e6, 0, 0};
  ExpectRefused("marker 0: it moves by", [&] { RenderScene(fast); });
  ExpectSceneRefused("reflection", [](Scene* s) { s->markers[0].R[2][2] = -1; });
  ExpectSceneRefused("rotation", [](Scene* s) { s->markers[0].R = {}; });
  ExpectSceneRefused("crosses itself", [](Scene* s) {
    // Ink grows over a strip of white from both sides.
    s->markers[0].growth = 0.3;
    s->markers[0].design.outer = OuterShape::kPolygon;
    s->markers[0].design.polygon = {{-9, -9},  {9, -9},  {9, -0.2}, {12, -0.2},
                                    {12, 0.2}, {9, 0.2}, {9, 9},    {-9, 9}};
  });
  ExpectSceneRefused("crosses itself", [](Scene* s) {
    // A needle that is one rounding wide: the edges at its tip have no mitre.
    s->markers[0].growth = 0.3;
    s->markers[0].design.outer = OuterShape::kPolygon;
    s->markers[0].design.polygon = {{-100, -100},
                                    {100, -100},
                                    {100, 100},
                                    {0.84626654082007324, 100},
                                    {23.816067610556725, 168.55232718871781},
                                    {0.84626654082007313, 100},
                                    {-100, 100}};
    s->markers[0].t[2] = 3;
  });
  for (const int shape : {-1, 77}) {
    ExpectSceneRefused(
        "inner", [&](Scene* s) { s->markers[0].design.inner = static_cast<InnerShape>(shape); });
    ExpectSceneRefused(
        "outer", [&](Scene* s) { s->markers[0].design.outer = static_cast<OuterShape>(shape); });
  }
  for (const int index : {-1, 1, INT_MIN, INT_MAX}) {
    ExpectRefused("not one of", [&] { GroundTruth(OneMarker(), index); });
  }
}

TEST(MisuseOfScenesTest, Pictures) {
  for (const double value : kNotFinite) {
    ExpectSceneRefused("background", [&](Scene* s) { s->background = value; });
    ExpectSceneRefused("blur", [&](Scene* s) { s->blur = value; });
    ExpectSceneRefused("noise", [&](Scene* s) { s->noise = value; });
    ExpectSceneRefused("exposure", [&](Scene* s) { s->exposure = value; });
    ExpectSceneRefused("row time", [&](Scene* s) { s->row_time = value; });
    ExpectSceneRefused("gain", [&](Scene* s) { s->lighting.gain = value; });
    ExpectSceneRefused("gradient", [&](Scene* s) { s->lighting.gradient.x = value; });
    ExpectSceneRefused("vignetting", [&](Scene* s) { s->lighting.vignetting = value; });
    ExpectSceneRefused("angle", [&](Scene* s) { s->lighting.shadow.emplace().angle = value; });
    ExpectSceneRefused("factor", [&](Scene* s) { s->lighting.shadow.emplace().factor = value; });
    ExpectSceneRefused("highlight",
                       [&](Scene* s) { s->lighting.highlights.emplace_back().sigma = value; });
    ExpectSceneRefused("outline", [&](Scene* s) {
      s->occluders.push_back({{{0, 0}, {1, 0}, {value, 1}}, 40, -1});
    });
    ExpectSceneRefused("fx", [&](Scene* s) { s->camera.fx = value; });
  }
  ExpectSceneRefused("fx 1e+16 pixels", [](Scene* s) { s->camera.fx = 1e16; });
  for (const int side : {0, -1, INT_MIN, INT_MAX, kMaxImageSide + 1}) {
    ExpectSceneRefused("", [&](Scene* s) { s->camera.width = s->camera.height = side; });
  }
  for (const int marker : {-2, 1, INT_MIN, INT_MAX}) {
    ExpectSceneRefused("marker", [&](Scene* s) {
      s->occluders.push_back({{{0, 0}, {1, 0}, {1, 1}}, 40, marker});
    });
  }
  ExpectSceneRefused("more than 4000 points", [](Scene* s) {
    s->occluders.push_back({std::vector<Point2>(4001, {1, 1}), 40, -1});
  });
  const uint8_t pixel = 0;
  ExpectSceneRefused("stride", [&](Scene* s) { s->background_image = {&pixel, 9, 9, 8}; });
  ExpectSceneRefused("size", [&](Scene* s) { s->background_image = {&pixel, -9, 9, 9}; });
}

// What is in range, but beyond sense, is refused or drawn somehow.
TEST(MisuseOfScenesTest, ExtremeValues) {
  for (const double value : {1e-300, 1e-9, 1e9, 1e300}) {
    for (const double sign : {-1.0, 1.0}) {
      const auto render = [&](const std::function<void(Scene*, double)>& change) {
        Scene scene = OneMarker();
        change(&scene, sign * value);
        ExpectDefined([&] { RenderScene(scene); });
        ExpectDefined([&] { GroundTruth(scene, 0); });
      };
      render([](Scene* s, double v) { s->markers[0].t[0] = v; });
      render([](Scene* s, double v) { s->markers[0].t[2] = std::abs(v); });
      render([](Scene* s, double v) { s->markers[0].tag_size = std::abs(v); });
      render([](Scene* s, double v) { s->camera.fx = s->camera.fy = std::abs(v); });
      render([](Scene* s, double v) { s->camera.cx = v; });
      render([](Scene* s, double v) {
        s->exposure = 0.01;
        s->markers[0].velocity = {v, 0, 0};
      });
      render([](Scene* s, double v) {
        s->row_time = 1e-3;
        s->markers[0].angular_velocity = {0, v, 0};
      });
      render([](Scene* s, double v) {
        s->camera.model = DistortionModel::kBrown;
        s->camera.distortion[0] = v;
      });
      render([](Scene* s, double v) {
        s->camera.model = DistortionModel::kFisheye;
        s->camera.distortion[3] = v;
      });
      render([](Scene* s, double v) { s->markers[0].design.frame = std::abs(v); });
    }
  }
}

TEST(MisuseOfScenesTest, Geometry) {
  const auto refuse = [](const std::string& part, std::vector<Point2> polygon) {
    MarkerDesign design;
    design.outer = OuterShape::kPolygon;
    design.polygon = std::move(polygon);
    ExpectRefused(part, [&] { BuildMarkerGeometry(design); });
  };
  refuse("0 points", {});
  refuse("2 points", {{0, 0}, {1, 1}});
  refuse("not simple", {{0, 0}, {9, 0}, {3, 0}});
  refuse("4001 points", std::vector<Point2>(4002));  // the last one closes it
  for (const double value : {kNan, kInf, 1e300}) {
    refuse("not within", {{-20, -20}, {20, -20}, {value, 20}});
  }
  for (const int vertex : {-1, 16, INT_MIN, INT_MAX}) {
    ExpectRefused("vertex", [&] { ModelVertex(Family(4), vertex); });
    ExpectRefused("vertex", [&] { IdBit(Family(4), 0, vertex); });
  }
  const Outline circle{{0, 0}, 1, {}};
  for (const int segments : {INT_MIN, 0, 2, INT_MAX}) {
    ExpectRefused("sides", [&] { Tessellate(circle, segments); });
  }
  ExpectRefused("union", [] { TessellateUnion({}, 8); });
  ExpectRefused("union", [&] { TessellateUnion({circle, circle, circle}, 8); });
  ExpectRefused("union", [] { TessellateUnion({Outline(), Outline()}, 8); });
  ExpectDefined([] { TessellateUnion({{{0, 0}, kNan, {}}, {{kNan, 0}, 1, {}}}, 8); });
  ExpectRefused("image size", [] { Image(0, 5); });
  ExpectRefused("image size", [] { Image(5, INT_MAX); });
}

TEST(MisuseOfScenesTest, ProjectionsOfNonsense) {
  for (const DistortionModel model :
       {DistortionModel::kNone, DistortionModel::kBrown, DistortionModel::kFisheye}) {
    Camera camera = test::PinholeCamera(64, 48, 100);
    camera.model = model;
    camera.distortion = {0.1, -0.2, 0.3, 0.1, 1e3, 1, 2, 3, 4, 5, 6, 7, 0.1, 1.5};
    for (const double value : {kNan, kInf, -kInf, 1e300, 1e-300, 1e9}) {
      Jacobian2 jacobian;
      Point2 normalized{1, 2};
      Project(camera, {value, 0}, &jacobian);
      Project(camera, {value, -value});
      const bool is_seen = Unproject(camera, {value, value}, &normalized);
      EXPECT_TRUE(is_seen ? std::isfinite(normalized.x) : normalized.x == 1);
    }
  }
}

// --- Objects -----------------------------------------------------------------------------------

Object Board() { return MakeGrid(Family(4), 0, 2, 2, 0.04, 0.06); }

Scene BoardScene() {
  Scene scene;
  scene.camera = test::PinholeCamera(640, 480, 600);
  for (const ObjectMarker& marker : Board().markers)
    scene.markers.push_back(test::Placed(marker, {}));
  return scene;
}

TEST(MisuseOfObjectsTest, Objects) {
  const Camera camera = BoardScene().camera;
  const auto refuse = [&](const std::string& part, const std::function<void(Object*)>& change) {
    Object object = Board();
    change(&object);
    ExpectRefused(part, [&] { ValidateObject(object); });
    ExpectRefused(part, [&] { ObjectPoseEstimator estimator(object, camera); });
    ExpectRefused(part, [&] { CalibrateObject(object, {}); });
  };
  refuse("no marker", [](Object* o) { o->markers.clear(); });
  refuse("ID", [](Object* o) { o->markers[1].id = UINT64_MAX; });
  refuse("marker", [](Object* o) { o->markers[1].id = o->markers[0].id; });
  for (const double value : kNotPositive) {
    refuse("size", [&](Object* o) { o->markers[1].tag_size = value; });
  }
  for (const double value : kNotFinite) {
    refuse("", [&](Object* o) { o->markers[1].t[2] = value; });
    refuse("", [&](Object* o) { o->markers[1].R[2][0] = value; });
  }
  refuse("", [](Object* o) { o->markers[1].R = {}; });
  Camera wrong = camera;
  wrong.fy = 0;
  ExpectRefused("fy", [&] { ObjectPoseEstimator estimator(Board(), wrong); });
}

TEST(MisuseOfObjectsTest, Makers) {
  for (const int side : {0, -1, INT_MIN, INT_MAX}) {
    ExpectRefused("", [&] { MakeGrid(Family(4), 0, side, 2, 0.04, 0.06); });
    ExpectRefused("", [&] { MakeGrid(Family(4), 0, 2, side, 0.04, 0.06); });
  }
  for (const double value : kNotPositive) {
    ExpectRefused("tag size", [&] { MakeGrid(Family(4), 0, 2, 2, value, 1); });
    ExpectRefused("pitch", [&] { MakeGrid(Family(4), 0, 2, 2, 0.04, value); });
    ExpectRefused("tag size", [&] { MakeRhombicuboctahedron(Family(4), 0, value, 1); });
    ExpectRefused("edge", [&] { MakeRhombicuboctahedron(Family(4), 0, 0.04, value); });
  }
  ExpectRefused("IDs", [] { MakeGrid(Family(4), UINT64_MAX, 2, 2, 0.04, 0.06); });
  ExpectRefused("IDs", [] { MakeRhombicuboctahedron(Family(3), 127, 0.04, 0.06); });
}

TEST(MisuseOfObjectsTest, MovedFromEstimatorAndNull) {
  const Scene scene = BoardScene();
  const std::vector<Detection> detections = test::ExactDetections(scene);
  ObjectPoseEstimator estimator(Board(), scene.camera);
  ExpectRefused("pose is null", [&] { estimator.estimate(detections, nullptr); });
  ObjectPoseEstimator other = std::move(estimator);
  ObjectPose pose;
  // NOLINTBEGIN(bugprone-use-after-move): that is what this is about
  ExpectRefused("moved from", [&] { estimator.estimate(detections, &pose); });
  ExpectRefused("moved from", [&] { estimator.object(); });
  // NOLINTEND(bugprone-use-after-move)
  EXPECT_TRUE(other.estimate(detections, &pose));
  estimator = std::move(other);
  EXPECT_TRUE(estimator.estimate(detections, &pose));
}

// Detections that are none: the others still give the pose, or there is none.
TEST(MisuseOfObjectsTest, Detections) {
  const Scene scene = BoardScene();
  const std::vector<Detection> good = test::ExactDetections(scene);
  ObjectPoseEstimator estimator(Board(), scene.camera);
  const auto damage = [&](const std::function<void(Detection*)>& change) {
    std::vector<Detection> detections = good;
    change(&detections[1]);
    ObjectPose pose;
    EXPECT_TRUE(estimator.estimate(detections, &pose));
    EXPECT_NEAR(pose.t[2], 0.4, 1e-6);
    for (Detection& detection : detections) change(&detection);
    ObjectPose untouched = pose;
    const bool is_found = estimator.estimate(detections, &pose);
    EXPECT_TRUE(is_found || pose.t == untouched.t);
    for (const double value : pose.t) EXPECT_FALSE(std::isnan(value));
    ExpectDefined([&] { CalibrateObject(Board(), {{scene.camera, detections}}); });
  };
  const auto give_pose = [](Detection* d, double value) {
    d->margin = 9;  // it counts by its pose
    d->pose.emplace();
    d->pose->t = {0, 0, value};
    for (size_t i = 0; i < 3; ++i) d->pose->R[i][i] = value;
    for (size_t i = 0; i < 6; ++i) d->pose->covariance[i][i] = 1;
    d->pose->alternative.emplace(*d->pose);
  };
  for (const double value : {kNan, kInf, -kInf, 1e300, -1e300, 0.0}) {
    damage([&](Detection* d) { d->vertices[5].x = value; });
    damage([&](Detection* d) {
      for (Point2& p : d->vertices) p = {value, value};
    });
    damage([&](Detection* d) { give_pose(d, value); });
    damage([&](Detection* d) {
      give_pose(d, 0.4);
      d->pose->covariance[3][2] = value;
    });
    damage([&](Detection* d) {
      give_pose(d, 0.4);
      d->pose->alternative->R[0][0] = value;
    });
  }
  damage([](Detection* d) { d->vertices.resize(0); });
  damage([](Detection* d) { d->vertices.resize(kMaxVertices); });
  damage([](Detection* d) { d->family = Family(8); });
  damage([](Detection* d) { d->id = UINT64_MAX; });
  damage([](Detection* d) { d->unknown_bits = UINT64_MAX; });
}

TEST(MisuseOfObjectsTest, Calibration) {
  const Scene scene = BoardScene();
  const std::vector<Detection> good = test::ExactDetections(scene);
  ExpectRefused("no view", [] { CalibrateObject(Board(), {}); });
  ExpectRefused("in no view", [&] { CalibrateObject(Board(), {{scene.camera, {}}}); });
  ExpectRefused("fx", [&] { CalibrateObject(Board(), {{Camera(), good}}); });
  ExpectRefused("frame", [&] {
    CalibrateObject(Board(), {{scene.camera, good}}, static_cast<ObjectFrame>(7));
  });
  std::vector<Detection> twice = good;
  twice.insert(twice.end(), good.begin(), good.end());
  ExpectRefused("in no view", [&] { CalibrateObject(Board(), {{scene.camera, twice}}); });
}

}  // namespace
}  // namespace topotag
