#include "topotag/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <random>
#include <string>
#include <vector>

#include "topotag/error.h"

namespace topotag {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Camera MakeCamera(DistortionModel model, std::array<double, 14> distortion) {
  Camera camera;
  camera.width = 1280;
  camera.height = 960;
  camera.fx = 921.3;
  camera.fy = 917.2;
  camera.cx = 649.2;
  camera.cy = 459.7;
  camera.model = model;
  camera.distortion = distortion;
  return camera;
}

Camera Brown(std::array<double, 14> distortion) {
  return MakeCamera(DistortionModel::kBrown, distortion);
}

Camera Fisheye(std::array<double, 14> distortion) {
  Camera camera = MakeCamera(DistortionModel::kFisheye, distortion);
  camera.fx = camera.fy = 560;
  return camera;
}

// Published calibrations of the authors' and a later paper's photographs: rational models.
Camera CubeCamera() {
  Camera camera =
      Brown({0.978811, 3.71217, 0.000159566, 0.000281263, 0.638837, 1.36651, 3.99066, 1.93969});
  camera.fx = 921.315;
  camera.fy = 921.375;
  camera.cx = 649.204;
  camera.cy = 459.739;
  return camera;
}

Camera PaperCamera() {
  Camera camera =
      Brown({7.75017, 25.6757, -0.000163367, -1.82517e-05, 4.14361, 8.12583, 28.6256, 12.7099});
  camera.fx = 917.347;
  camera.fy = 917.271;
  camera.cx = 647.297;
  camera.cy = 484.99;
  return camera;
}

// The official sample's: strong barrel, folds back at a distorted radius of 1.1706, inside the
// picture's corners, and has a pole further out.
Camera SampleCamera() {
  Camera camera = Brown(
      {0.74745, -0.0234192, 0.000148958, -0.000149384, -0.00925629, 1.07979, 0.129308, -0.0305814});
  camera.height = 800;
  camera.fx = 573.2;
  camera.fy = 572.459;
  camera.cx = 601.796;
  camera.cy = 409.043;
  return camera;
}

// One camera per number of OpenCV coefficients, and fisheye.
struct Lens {
  Camera camera;
  int coefficients;
};

std::vector<Lens> Lenses() {
  return {{MakeCamera(DistortionModel::kNone, {}), 0},
          {Brown({-0.28, 0.07, 1e-3, -2e-3}), 4},
          {Brown({-0.28, 0.09, 1e-3, -2e-3, -0.01}), 5},
          {CubeCamera(), 8},
          {PaperCamera(), 8},
          {SampleCamera(), 8},
          {Brown({-0.2, 0.05, 1e-3, -2e-3, 0.01, 0.05, 0.03, 0.004, 2e-3, -1e-3, 3e-3, 1e-3}), 12},
          {Brown({-0.2, 0.05, 1e-3, -2e-3, 0.01, 0.05, 0.03, 0.004, 2e-3, -1e-3, 3e-3, 1e-3, 0.1,
                  -0.07}),
           14},
          {Fisheye({-0.02, 0.012, -0.006, 0.001}), 4}};
}

std::string Name(const Lens& lens) {
  return std::string(lens.camera.model == DistortionModel::kFisheye ? "fisheye" : "brown") + " " +
         std::to_string(lens.coefficients) + ", k1 " + std::to_string(lens.camera.distortion[0]);
}

cv::Mat MatrixOf(const Camera& c) {
  return (cv::Mat_<double>(3, 3) << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
}

cv::Mat DistortionOf(const Lens& lens) {
  cv::Mat d(1, lens.coefficients, CV_64F);
  for (int i = 0; i < lens.coefficients; ++i) d.at<double>(i) = lens.camera.distortion[i];
  return d;
}

// Uniform in [-1, 1], the same on every machine.
double Uniform(std::mt19937_64* random) {
  return static_cast<double>((*random)() >> 11) * 0x1p-52 - 1;
}

double Distance(Point2 a, Point2 b) { return std::hypot(a.x - b.x, a.y - b.y); }

TEST(CameraTest, ProjectMatchesOpenCv) {
  std::mt19937_64 random(1);
  for (const Lens& lens : Lenses()) {
    SCOPED_TRACE(Name(lens));
    const double reach = lens.camera.model == DistortionModel::kFisheye ? 6 : 0.9;
    std::vector<cv::Point3d> points = {{0, 0, 1}, {1e-12, 0, 1}, {1e-9, -3e-9, 1}};
    for (int i = 0; i < 500; ++i) {
      points.push_back({reach * Uniform(&random), reach * Uniform(&random), 1});
    }
    const cv::Vec3d zero(0, 0, 0);
    std::vector<cv::Point2d> expected;
    if (lens.camera.model == DistortionModel::kFisheye) {
      cv::fisheye::projectPoints(points, expected, zero, zero, MatrixOf(lens.camera),
                                 DistortionOf(lens));
    } else {
      cv::projectPoints(points, zero, zero, MatrixOf(lens.camera), DistortionOf(lens), expected);
    }
    for (size_t i = 0; i < points.size(); ++i) {
      const Point2 pixel = Project(lens.camera, {points[i].x, points[i].y});
      ASSERT_NEAR(pixel.x, expected[i].x, 1e-9 * std::max(1.0, std::abs(expected[i].x)));
      ASSERT_NEAR(pixel.y, expected[i].y, 1e-9 * std::max(1.0, std::abs(expected[i].y)));
    }
  }
}

TEST(CameraTest, JacobianMatchesCentralDifferences) {
  std::mt19937_64 random(2);
  constexpr double kStep = 1e-5;
  for (const Lens& lens : Lenses()) {
    SCOPED_TRACE(Name(lens));
    for (int i = 0; i < 500; ++i) {
      const double reach = i < 20 ? 1e-7 : 0.9;
      const Point2 p{reach * Uniform(&random), reach * Uniform(&random)};
      Jacobian2 jacobian;
      const Point2 pixel = Project(lens.camera, p, &jacobian);
      ASSERT_EQ(pixel, Project(lens.camera, p));
      const Point2 right = Project(lens.camera, {p.x + kStep, p.y});
      const Point2 left = Project(lens.camera, {p.x - kStep, p.y});
      const Point2 down = Project(lens.camera, {p.x, p.y + kStep});
      const Point2 up = Project(lens.camera, {p.x, p.y - kStep});
      const Jacobian2 numeric = {(right.x - left.x) / (2 * kStep), (down.x - up.x) / (2 * kStep),
                                 (right.y - left.y) / (2 * kStep), (down.y - up.y) / (2 * kStep)};
      for (int k = 0; k < 4; ++k) ASSERT_NEAR(jacobian[k], numeric[k], 3e-5) << p.x << " " << p.y;
    }
  }
}

// Every pixel of a grid over the whole picture, its corners included.
std::vector<Point2> Grid(const Camera& camera) {
  std::vector<Point2> pixels;
  for (int i = 0; i <= 100; ++i) {
    for (int j = 0; j <= 100; ++j) {
      pixels.push_back({-0.5 + camera.width * i / 100.0, -0.5 + camera.height * j / 100.0});
    }
  }
  return pixels;
}

TEST(CameraTest, UnprojectInvertsProjectOverTheWholePicture) {
  for (const Lens& lens : Lenses()) {
    SCOPED_TRACE(Name(lens));
    const Camera& camera = lens.camera;
    for (const Point2& pixel : Grid(camera)) {
      Point2 p;
      const double radius =
          std::hypot((pixel.x - camera.cx) / camera.fx, (pixel.y - camera.cy) / camera.fy);
      if (camera.fx == 573.2 && radius > 1.165) continue;  // the sample's lens has an edge there
      ASSERT_TRUE(Unproject(camera, pixel, &p)) << pixel.x << " " << pixel.y;
      ASSERT_LT(Distance(Project(camera, p), pixel), 1e-9 * camera.fx * 0.2);
    }
  }
}

// From the ray, so that a solution on another branch shows.
TEST(CameraTest, UnprojectFindsTheRay) {
  std::mt19937_64 random(3);
  for (const Lens& lens : Lenses()) {
    SCOPED_TRACE(Name(lens));
    const double reach = lens.camera.model == DistortionModel::kFisheye ? 8 : 0.7;
    for (int i = 0; i < 20000; ++i) {
      const double scale = reach * std::exp2(-10.0 * (i % 100) / 100);
      const Point2 ray{scale * Uniform(&random), scale * Uniform(&random)};
      Point2 p;
      ASSERT_TRUE(Unproject(lens.camera, Project(lens.camera, ray), &p)) << ray.x << " " << ray.y;
      ASSERT_LT(Distance(p, ray), 1e-9 * (1 + ray.x * ray.x + ray.y * ray.y));
    }
  }
}

TEST(CameraTest, UnprojectMatchesOpenCv) {
  for (const Lens& lens : Lenses()) {
    SCOPED_TRACE(Name(lens));
    if (lens.coefficients == 0) continue;
    // Around the centre, where OpenCV's iterations converge as well.
    std::vector<cv::Point2d> pixels, expected;
    for (int i = -5; i <= 5; ++i) {
      for (int j = -5; j <= 5; ++j) {
        pixels.push_back({lens.camera.cx + 40.0 * i, lens.camera.cy + 40.0 * j});
      }
    }
    if (lens.camera.model == DistortionModel::kFisheye) {
      cv::fisheye::undistortPoints(pixels, expected, MatrixOf(lens.camera), DistortionOf(lens));
    } else {
      const cv::TermCriteria criteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 500, 1e-14);
      cv::undistortPoints(pixels, expected, MatrixOf(lens.camera), DistortionOf(lens),
                          cv::noArray(), cv::noArray(), criteria);
    }
    for (size_t i = 0; i < pixels.size(); ++i) {
      Point2 p;
      ASSERT_TRUE(Unproject(lens.camera, {pixels[i].x, pixels[i].y}, &p));
      ASSERT_NEAR(p.x, expected[i].x, 2e-8);
      ASSERT_NEAR(p.y, expected[i].y, 2e-8);
    }
  }
}

bool IsRefused(const Camera& camera, Point2 pixel) {
  Point2 p{-7, -7};
  const bool ok = Unproject(camera, pixel, &p);
  if (!ok) {
    EXPECT_EQ(p, (Point2{-7, -7}));
  }
  return !ok;
}

Point2 PixelAt(const Camera& camera, double radius, double angle) {
  return {camera.cx + camera.fx * radius * std::cos(angle),
          camera.cy + camera.fy * radius * std::sin(angle)};
}

TEST(CameraTest, UnprojectRefusesBeyondTheFold) {
  // r - r^3 / 3 turns at r = 1, where it is 2 / 3; beyond it comes back through every value.
  const Camera cubic = Brown({-1.0 / 3});
  // theta - 0.3 theta^3 turns at theta = 1.05409, where it is 0.70273.
  const Camera fisheye = Fisheye({-0.3});
  const Camera sample = SampleCamera();
  for (int i = 0; i < 360; ++i) {
    const double angle = i * 0.0174532925;
    for (const auto& [camera, edge] :
         {std::pair<Camera, double>{cubic, 2.0 / 3}, {fisheye, 0.70273}, {sample, 1.1706}}) {
      Point2 p;
      ASSERT_TRUE(Unproject(camera, PixelAt(camera, edge - 0.006, angle), &p)) << edge << " " << i;
      ASSERT_TRUE(IsRefused(camera, PixelAt(camera, edge + 0.006, angle))) << edge << " " << i;
      ASSERT_TRUE(IsRefused(camera, PixelAt(camera, edge + 1, angle)));
      ASSERT_TRUE(IsRefused(camera, PixelAt(camera, edge + 1e6, angle)));
    }
    Point2 p;
    ASSERT_TRUE(Unproject(cubic, PixelAt(cubic, 0.66, angle), &p));
    ASSERT_LT(std::hypot(p.x, p.y), 1);
  }
}

TEST(CameraTest, UnprojectStaysOnTheCentralBranch) {
  // Rays beyond the fold or the pole project to pixels that the centre sees as well, or to none.
  std::mt19937_64 random(4);
  const std::vector<Camera> cameras = {
      SampleCamera(), Brown({-1.0 / 3}), Brown({0, 0, 0, 0, 0, -0.5}), Brown({-2, 1.1}),
      // Poles at r^2 = 1 and 2.5, zeros at 1.5 and 4: the radius grows on every branch.
      Brown({-11.0 / 12, 1.0 / 6, 0, 0, 0, -1.4, 0.4}),
      Brown({-0.9, 0.3, 0.01, -0.01, 0.2, 0, 0, 0, 0.02, 0.01, -0.01, 0.02})};
  for (const Camera& camera : cameras) {
    int found = 0;
    for (int i = 0; i < 20000; ++i) {
      const Point2 ray{4 * Uniform(&random), 4 * Uniform(&random)};
      const Point2 pixel = Project(camera, ray);
      Point2 p;
      if (!Unproject(camera, pixel, &p)) continue;
      ++found;
      Jacobian2 slope;
      const double error = Distance(Project(camera, p, &slope), pixel);
      ASSERT_LT(error,
                1e-9 * std::hypot(std::hypot(slope[0], slope[1]), std::hypot(slope[2], slope[3])));
      // Along the way from the centre, the radius only grows.
      for (int k = 0; k <= 50; ++k) {
        const Point2 q{p.x * k / 50, p.y * k / 50};
        Jacobian2 j;
        Project(camera, q, &j);
        const double radial = p.x * (j[0] / camera.fx * p.x + j[1] / camera.fx * p.y) +
                              p.y * (j[2] / camera.fy * p.x + j[3] / camera.fy * p.y);
        ASSERT_GT(radial, 0) << p.x << " " << p.y << " " << k;
        ASSERT_GT(j[0] * j[3] - j[1] * j[2], 0);
        const double u = q.x * q.x + q.y * q.y;
        const auto& d = camera.distortion;
        ASSERT_GT(1 + u * (d[5] + u * (d[6] + u * d[7])), 0);
      }
    }
    EXPECT_GT(found, 100);
  }
}

TEST(CameraTest, UnprojectRefusesWhatNoRayReaches) {
  // The tilted sensor's horizon: the plane through the centre, parallel to the lens.
  const Camera tilted = Brown({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.5});
  const double horizon = 1 / std::tan(0.5) * std::cos(0.5);
  Point2 p;
  int refused = 0;
  for (double radius = -40; radius <= 40; radius += 0.25) {
    const Point2 pixel = PixelAt(tilted, radius, 0);
    if (Unproject(tilted, pixel, &p)) {
      EXPECT_LT(Distance(Project(tilted, p), pixel), 1e-6 * (1 + std::abs(radius)));
    } else {
      ++refused;
      EXPECT_GT(std::abs(radius), 0.9 * horizon);
    }
  }
  EXPECT_GT(refused, 10);
  // An equidistant lens without coefficients ends at 90 degrees.
  const Camera fisheye = Fisheye({});
  ASSERT_TRUE(Unproject(fisheye, PixelAt(fisheye, 1.57, 2), &p));
  EXPECT_NEAR(std::hypot(p.x, p.y), std::tan(1.57), 1e-6 * std::tan(1.57));
  EXPECT_TRUE(IsRefused(fisheye, PixelAt(fisheye, 1.5709, 2)));
}

TEST(CameraTest, UnprojectNeverReturnsNan) {
  std::vector<Camera> cameras;
  for (const Lens& lens : Lenses()) cameras.push_back(lens.camera);
  for (const DistortionModel model : {DistortionModel::kBrown, DistortionModel::kFisheye}) {
    for (const double value : {1e300, -1e300, 1e30, -1e30, 100.0, -100.0, kNan, kInfinity}) {
      for (int i = 0; i < 14; ++i) {
        cameras.push_back(MakeCamera(model, {}));
        cameras.back().distortion[i] = value;
        cameras.push_back(SampleCamera());
        cameras.back().model = model;
        cameras.back().distortion[i] = value;
      }
    }
  }
  const double values[] = {649.2, 0,     -1,        1279.5,     1e5, -1e18,
                           1e200, 1e308, kInfinity, -kInfinity, kNan};
  for (const Camera& camera : cameras) {
    for (double x : values) {
      for (double y : values) {
        Point2 p{1, 2};
        if (Unproject(camera, {x, y}, &p)) {
          EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y));
          EXPECT_TRUE(std::isfinite(x) && std::isfinite(y));
        }
      }
    }
  }
}

// Rays up to where a random lens starts to fold, by dense sampling; returns those refused.
int CheckRandomLens(const Camera& camera, double angle, int* rays) {
  const Point2 direction{std::cos(angle), std::sin(angle)};
  int refused = 0;
  for (int i = 1; i <= 400; ++i) {
    const double r = i * 0.005, u = r * r;
    const Point2 ray{r * direction.x, r * direction.y};
    Jacobian2 j;
    const Point2 pixel = Project(camera, ray, &j);
    const double radial = direction.x * (j[0] * direction.x + j[1] * direction.y) +
                          direction.y * (j[2] * direction.x + j[3] * direction.y);
    const auto& d = camera.distortion;
    const bool fisheye = camera.model == DistortionModel::kFisheye;
    const double denominator = fisheye ? 1 : 1 + u * (d[5] + u * (d[6] + u * d[7]));
    if (!(radial > 0.1) || !(denominator > 0.05)) break;
    if (i % 20 != 0) continue;
    ++*rays;
    Point2 p;
    if (Unproject(camera, pixel, &p)) {
      EXPECT_LT(Distance(p, ray), 1e-9) << i << " fisheye " << fisheye;
    } else {
      ++refused;
    }
  }
  return refused;
}

TEST(CameraTest, UnprojectWorksOnRandomLenses) {
  std::mt19937_64 random(5);
  int rays = 0, refused = 0;
  for (int i = 0; i < 6000; ++i) {
    Camera camera = i % 4 == 3 ? Fisheye({}) : Brown({});
    camera.fx = camera.fy = 1;
    camera.cx = camera.cy = 0;
    const double strength = std::exp2(2.5 * Uniform(&random));
    if (i % 4 == 3) {
      for (int k = 0; k < 4; ++k) camera.distortion[k] = 0.1 * strength * Uniform(&random);
    } else {
      for (int k : {0, 1, 4}) camera.distortion[k] = strength * Uniform(&random);
      for (int k : {2, 3}) camera.distortion[k] = 0.002 * Uniform(&random);
      for (int k : {5, 6, 7}) {
        if (i % 2 == 1) camera.distortion[k] = strength * Uniform(&random);
      }
    }
    refused += CheckRandomLens(camera, 3.14159 * Uniform(&random), &rays);
  }
  EXPECT_GT(rays, 30000);
  // Close to a fold the proof that the lens is one-to-one is allowed to fail.
  EXPECT_LT(refused, rays / 1000);
}

void ExpectInvalid(const Camera& camera, const std::string& field) {
  try {
    ValidateCamera(camera);
    FAIL() << field;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
  }
}

TEST(CameraTest, ValidateNamesTheField) {
  for (const Lens& lens : Lenses()) EXPECT_NO_THROW(ValidateCamera(lens.camera));
  const auto with = [](auto set) {
    Camera camera = CubeCamera();
    set(&camera);
    return camera;
  };
  EXPECT_NO_THROW(ValidateCamera(with([](Camera* c) { c->width = c->height = 0; })));
  for (double extreme : {1e-9, 1e9}) {
    EXPECT_NO_THROW(ValidateCamera(with([&](Camera* c) { c->fx = c->fy = extreme; })));
    EXPECT_NO_THROW(ValidateCamera(with([&](Camera* c) { c->cx = -(c->cy = extreme); })));
  }
  for (double bad : {0.0, -1.0, kNan, kInfinity, 1e-10, 1.1e9, 1e300}) {
    ExpectInvalid(with([&](Camera* c) { c->fx = bad; }), "fx");
    ExpectInvalid(with([&](Camera* c) { c->fy = bad; }), "fy");
  }
  for (double bad : {kNan, kInfinity, -kInfinity, 1.1e9, -8e13, 1e300}) {
    ExpectInvalid(with([&](Camera* c) { c->cx = bad; }), "cx");
    ExpectInvalid(with([&](Camera* c) { c->cy = bad; }), "cy");
  }
  for (double bad : {kNan, kInfinity, -kInfinity}) {
    for (int i = 0; i < 14; ++i) {
      ExpectInvalid(with([&](Camera* c) { c->distortion[i] = bad; }),
                    "distortion[" + std::to_string(i) + "]");
    }
  }
  ExpectInvalid(with([](Camera* c) { c->width = -1; }), "width");
  ExpectInvalid(with([](Camera* c) { c->height = -1; }), "height");
  ExpectInvalid(with([](Camera* c) { c->width = 0; }), "0x960");
  ExpectInvalid(with([](Camera* c) { c->height = 0; }), "1280x0");
}

}  // namespace
}  // namespace topotag
