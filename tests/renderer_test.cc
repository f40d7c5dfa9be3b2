// Rendered markers against closed forms and against their ground truth.
#include "topotag/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/renderer_test_util.h"

namespace topotag {
namespace {

TEST(RendererTest, GreyLevelsOfEveryArea) {
  for (const OuterShape outer :
       {OuterShape::kSquare, OuterShape::kCircle, OuterShape::kButterfly, OuterShape::kPolygon}) {
    for (const InnerShape inner :
         {InnerShape::kSquare, InnerShape::kCircle, InnerShape::kHexagon}) {
      Scene scene = FrontalScene(600, 600, 300, 300, 12);
      MarkerDesign& design = scene.markers[0].design;
      design.inner = inner;
      design.outer = outer;
      design.polygon = {{-9, -9}, {9, -9}, {9, 9}, {-9, 9}};
      design.margin = 1;
      const Image image = RenderScene(scene);
      const auto unit = [&](double x, double y) { return At(image, 300 + 12 * x, 300 + 12 * y); };
      EXPECT_EQ(unit(0, 0), kWhite);       // between the nodes
      EXPECT_EQ(unit(-5, -6), kBlack);     // between the baseline's holes
      EXPECT_EQ(unit(-6, -6), kWhite);     // p1's hole
      EXPECT_EQ(unit(2, -6), kWhite);      // 8390: v2 is 1,
      EXPECT_EQ(unit(6, -6), kBlack);      // v3 is 0,
      EXPECT_EQ(unit(6, 6), kBlack);       // the last is 0,
      EXPECT_EQ(unit(2, 6), kWhite);       // the one before is 1
      EXPECT_EQ(unit(2 + 1, -6), kBlack);  // around a hole
      EXPECT_EQ(image.row(0)[0], kBackground);
    }
  }
}

TEST(RendererTest, FrameAndMarginAreOptional) {
  const auto level = [](double frame, double margin, double x) {
    Scene scene = FrontalScene(400, 400, 200, 200, 16);
    scene.markers[0].design.frame = frame;
    scene.markers[0].design.margin = margin;
    return At(RenderScene(scene), 200 + 16 * x, 200);
  };
  EXPECT_EQ(level(0, 0, 8.9), kBackground);
  EXPECT_EQ(level(0, 0, 8.1), kWhite);
  EXPECT_EQ(level(0, 1, 8.9), kWhite);
  EXPECT_EQ(level(0, 1, 10), kBackground);
  EXPECT_EQ(level(1, 0, 8.9), kBlack);
  EXPECT_EQ(level(1, 0, 10), kBackground);
  EXPECT_EQ(level(1, 1, 8.9), kBlack);
  EXPECT_EQ(level(1, 1, 10), kWhite);
  EXPECT_EQ(level(1, 1, 11), kBackground);
}

TEST(RendererTest, TotalIntensityIsTheSumOfTheAreas) {
  for (const double blur : {0.0, 0.5, 1.3}) {
    Scene scene = FrontalScene(420, 420, 209.37, 210.61, 15.3);
    scene.blur = blur;
    scene.markers[0].R = Rotation({0, 0, 1}, 0.41);
    const Image image = RenderScene(scene);
    double sum = 0;
    for (int y = 0; y < 420; ++y) {
      for (int x = 0; x < 420; ++x) sum += image.row(y)[x] - kBackground;
    }
    // Square units: frame and white area 19 x 19 and 17 x 17; the baseline node 5 x 3, 14 others
    // 3 x 3; of ID 8390's 14 bits 5 are set, and the baseline has 2 holes.
    const double white = 17 * 17, nodes = 15 + 14 * 9, holes = 7;
    const double expected =
        (19 * 19 * (kBlack - kBackground) + (white - nodes + holes) * (kWhite - kBlack)) * 15.3 *
        15.3;
    // Rounding: about 0.3 levels, independent, in each of some 10,000 pixels near edges.
    EXPECT_NEAR(sum, expected, 150) << "blur " << blur;
  }
}

TEST(RendererTest, BlurredEdgeFollowsTheErrorFunction) {
  for (const double blur : {0.0, 0.3, 0.6, 0.7, 1.5}) {
    Scene scene = FrontalScene(400, 400, 199.83, 200.21, 20.31);
    scene.blur = blur;
    scene.markers[0].design.frame = 0;
    const Image image = RenderScene(scene);    // row 119 lies between two rows of nodes
    const double edge = 199.83 - 8.5 * 20.31;  // left edge of the white area
    for (int x = 15; x < 44; ++x) {
      double covered = 0;  // box-integrated over the pixel
      constexpr int kSamples = 2000;
      for (int i = 0; i < kSamples; ++i) {
        const double d = x - 0.5 + (i + 0.5) / kSamples - edge;
        covered += blur > 0 ? 0.5 * std::erfc(-d / blur * M_SQRT1_2) : d > 0;
      }
      const double expected = kBackground + covered / kSamples * (kWhite - kBackground);
      EXPECT_NEAR(image.row(119)[x], expected, 0.52) << "blur " << blur << ", x " << x;
    }
  }
}

// Centroid of darkness within `radius` pixels of a point.
Point2 DarkCentroid(const Image& image, Point2 center, double radius) {
  double sum = 0, sum_x = 0, sum_y = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (std::hypot(x - center.x, y - center.y) > radius) continue;
      const double dark = kWhite - image.row(y)[x];
      sum += dark;
      sum_x += dark * x;
      sum_y += dark * y;
    }
  }
  return {sum_x / sum, sum_y / sum};
}

TEST(RendererTest, FrontalNodesAreCenteredOnTheirVertices) {
  for (int k = 0; k < 6; ++k) {
    Scene scene = FrontalScene(400, 400, 199.3 + 0.17 * k, 200.1 - 0.13 * k, 15.1 + 0.37 * k);
    scene.markers[0].design.inner = InnerShape::kCircle;
    scene.markers[0].R = Rotation({0, 0, 1}, 0.05 + k);
    const Image image = RenderScene(scene);
    const Detection truth = GroundTruth(scene, 0);
    for (int v = 2; v < truth.vertices.size(); ++v) {
      const Point2 vertex = truth.vertices[v];
      const Point2 measured = DarkCentroid(image, vertex, 2 * (15.1 + 0.37 * k));
      EXPECT_NEAR(measured.x, vertex.x, 0.005) << k << ", vertex " << v;
      EXPECT_NEAR(measured.y, vertex.y, 0.005) << k << ", vertex " << v;
    }
  }
}

Point2 ProjectTag(const Scene& scene, Point2 p) {
  const SceneMarker& m = scene.markers[0];
  const double u = m.tag_size / m.design.family.white_side();
  std::array<double, 3> q;
  for (int i = 0; i < 3; ++i) q[i] = u * (m.R[i][0] * p.x + m.R[i][1] * p.y) + m.t[i];
  return Project(scene.camera, {q[0] / q[2], q[1] / q[2]});
}

// Centroid of the image of a disc, by sampling the disc: independent of any outline.
Point2 DiscCentroid(const Scene& scene, Point2 center, double radius) {
  constexpr int kSamples = 120;
  constexpr double kStep = 1e-4;
  double sum = 0, sum_x = 0, sum_y = 0;
  for (int j = 0; j < kSamples; ++j) {
    for (int i = 0; i < kSamples; ++i) {
      const double dx = (2 * i + 1.0) / kSamples - 1, dy = (2 * j + 1.0) / kSamples - 1;
      if (dx * dx + dy * dy > 1) continue;
      const double x = center.x + radius * dx, y = center.y + radius * dy;
      const Point2 a = ProjectTag(scene, {x, y}), b = ProjectTag(scene, {x + kStep, y}),
                   c = ProjectTag(scene, {x, y + kStep});
      const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
      sum += area;
      sum_x += area * a.x;
      sum_y += area * a.y;
    }
  }
  return {sum_x / sum, sum_y / sum};
}

std::vector<Camera> TestLenses() {
  Camera pinhole;
  pinhole.width = pinhole.height = 400;
  pinhole.fx = 380;
  pinhole.fy = 400;
  pinhole.cx = 170;
  pinhole.cy = 230;
  Camera barrel = pinhole, rational = pinhole, fisheye = pinhole;
  barrel.model = rational.model = DistortionModel::kBrown;
  barrel.distortion = {-0.25, 0.06, 1e-3, -2e-3};
  rational.distortion = {0.3, 0.1, -1e-3, 5e-4, 0.02, 0.5, 0.15, 0.03};
  fisheye.model = DistortionModel::kFisheye;
  fisheye.distortion = {0.02, -0.01, 0.003, -0.001};
  return {pinhole, barrel, rational, fisheye};
}

TEST(RendererTest, TiltedNodesLieWhereLensAndPosePutThem) {
  int index = 0;
  for (const Camera& camera : TestLenses()) {
    Scene scene = FrontalScene(400, 400, 0, 0, 20);
    scene.camera = camera;
    MarkerDesign& design = scene.markers[0].design;
    design.inner = InnerShape::kCircle;
    design.id = 0;  // solid nodes
    scene.markers[0].R = Rotation({0.8, 0.5, 0.3}, 0.7);
    scene.markers[0].t = {0.003, -0.004, 0.075};
    const Image image = RenderScene(scene);
    const Detection truth = GroundTruth(scene, 0);
    const std::vector<Point2> model = ModelVertices(design.family);
    for (int v = 2; v < truth.vertices.size(); ++v) {
      const Point2 vertex = ProjectTag(scene, model[v]);
      EXPECT_NEAR(truth.vertices[v].x, vertex.x, 1e-9);
      EXPECT_NEAR(truth.vertices[v].y, vertex.y, 1e-9);
      // A window that takes in the whole node and no part of another.
      double radius = 1e9;
      for (int w = 0; w < truth.vertices.size(); ++w) {
        if (w == v) continue;
        radius = std::min(radius, 0.5 * std::hypot(truth.vertices[w].x - vertex.x,
                                                   truth.vertices[w].y - vertex.y));
      }
      const Point2 expected = DiscCentroid(scene, model[v], 1.5);
      double reach = 0;
      for (int i = 0; i < 16; ++i) {
        const Point2 rim = ProjectTag(scene, {model[v].x + 1.5 * std::cos(i * M_PI / 8),
                                              model[v].y + 1.5 * std::sin(i * M_PI / 8)});
        reach = std::max(reach, std::hypot(rim.x - vertex.x, rim.y - vertex.y));
      }
      if (reach + 2.5 > radius) continue;
      ++index;
      const Point2 measured = DarkCentroid(image, vertex, reach + 2.5);
      EXPECT_NEAR(measured.x, expected.x, 0.01) << "vertex " << v;
      EXPECT_NEAR(measured.y, expected.y, 0.01) << "vertex " << v;
    }
  }
  EXPECT_GE(index, 20) << "too few nodes stand clear of their neighbours to test anything";
}

TEST(RendererTest, GroundTruthHoldsTheContractsOrder) {
  Scene scene = FrontalScene(300, 300, 150, 140, 10);
  scene.markers[0].design.family = Family(3);
  scene.markers[0].design.id = 100;
  scene.markers[0].t[2] *= 17.0 / 13.0;
  const Detection truth = GroundTruth(scene, 0);
  EXPECT_EQ(truth.family, Family(3));
  EXPECT_EQ(truth.id, 100u);
  const std::array<Point2, 4> corners{{{-65, -65}, {65, -65}, {65, 65}, {-65, 65}}};
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(truth.corners[i].x, 150 + corners[i].x, 1e-9);
    EXPECT_NEAR(truth.corners[i].y, 140 + corners[i].y, 1e-9);
  }
  EXPECT_NEAR(truth.center.x, 150, 1e-9);
  EXPECT_NEAR(truth.center.y, 140, 1e-9);
  ASSERT_EQ(truth.vertices.size(), 9);
  EXPECT_NEAR(truth.vertices[0].x, 150 - 40, 1e-9);
  EXPECT_NEAR(truth.vertices[1].x, 150 - 20, 1e-9);
  EXPECT_NEAR(truth.vertices[2].x, 150 + 40, 1e-9);
  EXPECT_NEAR(truth.vertices[8].y, 140 + 40, 1e-9);
  ASSERT_TRUE(truth.pose.has_value());
  EXPECT_EQ(truth.pose->R, scene.markers[0].R);
  EXPECT_EQ(truth.pose->t, scene.markers[0].t);
  EXPECT_EQ(truth.pose->rms_px, 0);
  EXPECT_EQ(truth.pose->covariance, Matrix6{});
}

TEST(RendererTest, FrameBordersEqualTheCropOfALargerFrame) {
  for (const Camera& lens : TestLenses()) {
    for (const double blur : {0.0, 0.7, 2.5}) {
      // Tall enough to be rendered in several bands, with a border across the marker.
      Scene large = FrontalScene(1500, 900, 0, 0, 20);
      large.camera = lens;
      large.camera.width = 1500;
      large.camera.height = 900;
      large.camera.cx = 700;
      large.camera.cy = 370;
      large.blur = blur;
      large.markers[0].R = Rotation({0.3, -0.6, 0.9}, 0.5);
      large.markers[0].t = {0.004, 0.002, 0.08};
      const Image reference = RenderScene(large);
      for (const Rect& crop : {Rect{640, 300, 120, 90}, Rect{400, 250, 310, 100},
                               Rect{750, 150, 31, 400}, Rect{715, 345, 1, 1}}) {
        Scene small = large;
        small.camera.width = crop.width;
        small.camera.height = crop.height;
        small.camera.cx -= crop.x;
        small.camera.cy -= crop.y;
        ExpectSame(Compare(RenderScene(small),
                           [&](int x, int y) { return reference.row(y + crop.y)[x + crop.x]; }));
      }
    }
  }
}

TEST(RendererTest, SeenFromBehindTheMarkerIsMirrored) {
  Scene scene = FrontalScene(301, 301, 150, 150, 11.3);
  const Image front = RenderScene(scene);
  scene.markers[0].R = {{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}}};
  ExpectSame(Compare(RenderScene(scene), [&](int x, int y) { return front.row(y)[300 - x]; }));
}

}  // namespace
}  // namespace topotag
