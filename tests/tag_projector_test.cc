// How closely projected outlines follow circles and lens distortion.
#include "host/tag_projector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/renderer_test_util.h"
#include "topotag/error.h"

namespace topotag {
namespace {

// A marker of 300 to 1,000 pixels, tilted, under a barrel lens or none.
Scene TestScene(bool distorted, double depth) {
  Scene scene = FrontalScene(1280, 960, 640, 480, 20);
  scene.camera.fx = scene.camera.fy = 700;
  if (distorted) {
    scene.camera.model = DistortionModel::kBrown;
    scene.camera.distortion = {-0.25, 0.06, 1e-3, -2e-3};
  }
  scene.markers[0].R = Rotation({0.8, 0.5, 0.3}, 0.5);
  scene.markers[0].t = {0.001, -0.002, depth};
  return scene;
}

double DistanceToOutline(const std::vector<Point2>& outline, Point2 p) {
  double nearest = 1e9;
  for (size_t i = 0; i < outline.size(); ++i) {
    const Point2 a = outline[i], b = outline[(i + 1) % outline.size()];
    const double dx = b.x - a.x, dy = b.y - a.y;
    const double t = ((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy);
    const double s = std::clamp(t, 0.0, 1.0);
    nearest = std::min(nearest, std::hypot(a.x + s * dx - p.x, a.y + s * dy - p.y));
  }
  return nearest;
}

TEST(TagProjectorTest, EdgesFollowTheLens) {
  for (const double depth : {0.12, 0.06}) {
    const Scene scene = TestScene(true, depth);
    const TagProjector project(scene, 0);
    const std::vector<Point2> square{{-8.5, -8.5}, {8.5, -8.5}, {8.5, 8.5}, {-8.5, 8.5}};
    const std::vector<Point2> outline = project.Outlined(square);
    EXPECT_GT(outline.size(), 40u);
    double largest = 0;
    for (int i = 0; i < 4; ++i) {
      const Point2 a = square[i], b = square[(i + 1) % 4];
      for (int k = 0; k < 2000; ++k) {
        const double s = k / 2000.0;
        const Point2 p = project({a.x + s * (b.x - a.x), a.y + s * (b.y - a.y)});
        if (p.x < 0 || p.y < 0 || p.x > 1279 || p.y > 959) continue;
        largest = std::max(largest, DistanceToOutline(outline, p));
      }
    }
    EXPECT_LE(largest, 1.05 * TagProjector::kOutlineTolerance) << depth;
  }
}

TEST(TagProjectorTest, WithoutLensEdgesStayWhole) {
  const Scene scene = TestScene(false, 0.1);
  const std::vector<Point2> square{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  EXPECT_EQ(TagProjector(scene, 0).Outlined(square).size(), 4u);
}

TEST(TagProjectorTest, PolygonsFollowCircles) {
  for (const bool distorted : {false, true}) {
    const Scene scene = TestScene(distorted, 0.1);
    const TagProjector project(scene, 0);
    for (const double radius : {0.5, 1.5, 8.0}) {
      const Outline circle{{-2, 2}, radius, {}};
      const auto outline = project.Outlined(Tessellate(circle, project.CircleSegments(circle)));
      double largest = 0;
      for (int k = 0; k < 5000; ++k) {
        const double angle = k * 2 * M_PI / 5000;
        const Point2 p = project({-2 + radius * std::cos(angle), 2 + radius * std::sin(angle)});
        largest = std::max(largest, DistanceToOutline(outline, p));
      }
      EXPECT_LE(largest, 1.05 * TagProjector::kOutlineTolerance) << radius;
      // Not finer than it needs to be, either: rendering time is proportional to it.
      EXPECT_GT(largest, 0.1 * TagProjector::kOutlineTolerance) << radius;
    }
  }
}

TEST(TagProjectorTest, LensIsCheckedWhereTheFrameShowsIt) {
  Scene scene = FrontalScene(200, 200, 100, 100, 4);
  scene.camera.fx = scene.camera.fy = 100;
  scene.camera.model = DistortionModel::kBrown;
  scene.camera.distortion = {-1};  // r - r^3 folds at r = 0.577, 38 pixels from the centre
  scene.markers[0].tag_size = 17;  // a unit is a metre
  scene.markers[0].t = {0, 0, 10};
  const TagProjector project(scene, 0);
  EXPECT_NO_THROW(project.Visible({5, 0}));
  EXPECT_THROW(project.Visible({6, 0}), Error);  // r = 0.6 appears at 0.384, inside the fold
  EXPECT_NO_THROW(project.Visible({20, 0}));     // r = 2 appears at -6, out of the frame
}

}  // namespace
}  // namespace topotag
