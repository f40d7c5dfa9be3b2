// The rasterizer against closed forms and against an independent clipper.
#include "host/area_raster.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "topotag/marker.h"

namespace topotag {
namespace {

using Polygon = std::vector<Point2>;

constexpr double kExact = 1e-11;
// The documented error with blur.
constexpr double kBlurred = 2e-6;

AreaRaster Rasterize(const Polygon& polygon, const PixelResponse& response, const Rect& area) {
  AreaRaster raster(response, area);
  raster.Add(polygon, 1);
  raster.Finish();
  return raster;
}

Polygon Rectangle(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

Polygon RotatedSquare(Point2 center, double side, double angle) {
  Polygon square;
  for (const double corner : {0.25, 0.75, 1.25, 1.75}) {
    const double a = angle + corner * M_PI, r = side * M_SQRT1_2;
    square.push_back({center.x + r * std::cos(a), center.y + r * std::sin(a)});
  }
  return square;
}

double Overlap(double a0, double a1, double b0, double b1) {
  return std::max(0.0, std::min(a1, b1) - std::max(a0, b0));
}

double Area(const Polygon& polygon) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Point2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    twice += a.x * b.y - b.x * a.y;
  }
  return std::abs(0.5 * twice);
}

// Area of a convex polygon of positive orientation within one pixel: Sutherland-Hodgman.
double ClippedArea(const Polygon& convex, double x, double y) {
  Polygon part = Rectangle(x - 0.5, y - 0.5, x + 0.5, y + 0.5);
  for (size_t i = 0; i < convex.size(); ++i) {
    const Point2 a = convex[i], b = convex[(i + 1) % convex.size()];
    const auto side = [&](Point2 p) {
      return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    };
    Polygon kept;
    for (size_t k = 0; k < part.size(); ++k) {
      const Point2 p = part[k], q = part[(k + 1) % part.size()];
      const double sp = side(p), sq = side(q);
      if (sp >= 0) kept.push_back(p);
      if ((sp >= 0) != (sq >= 0)) {
        const double t = sp / (sp - sq);
        kept.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
      }
    }
    part = kept;
  }
  return part.empty() ? 0 : Area(part);
}

double Sum(const AreaRaster& raster, const Rect& area) {
  double sum = 0;
  for (int y = area.y; y < area.y + area.height; ++y) {
    for (int x = 0; x < area.width; ++x) sum += raster.row(y)[x];
  }
  return sum;
}

TEST(AreaRasterTest, CoverageOfSquareAtFractionalOffsets) {
  const PixelResponse response(0);
  for (int k = 0; k <= 20; ++k) {
    const double x0 = 2.5 + 0.05 * k, y0 = 3.5 + 0.05 * (k * 7 % 21);
    const double x1 = x0 + 5.3, y1 = y0 + 0.4;
    const AreaRaster raster = Rasterize(Rectangle(x0, y0, x1, y1), response, {1, 2, 12, 9});
    for (int y = 2; y < 11; ++y) {
      for (int x = 1; x < 13; ++x) {
        const double expected =
            Overlap(x0, x1, x - 0.5, x + 0.5) * Overlap(y0, y1, y - 0.5, y + 0.5);
        EXPECT_NEAR(raster.row(y)[x - 1], expected, kExact) << k << ": " << x << ", " << y;
      }
    }
  }
}

TEST(AreaRasterTest, CoverageOfRotatedSquareEqualsClipping) {
  const PixelResponse response(0);
  for (const double angle : {0.001, 0.3, M_PI / 4, 1.2, 3.0}) {
    const Polygon square = RotatedSquare({15.2, 14.9}, 13.7, angle);
    const Rect area{0, 0, 30, 30};
    const AreaRaster raster = Rasterize(square, response, area);
    for (int y = 0; y < 30; ++y) {
      for (int x = 0; x < 30; ++x) {
        EXPECT_NEAR(raster.row(y)[x], ClippedArea(square, x, y), kExact) << x << ", " << y;
      }
    }
    EXPECT_NEAR(Sum(raster, area), 13.7 * 13.7, 1e-9);
  }
}

TEST(AreaRasterTest, CircleHasItsArea) {
  const Rect area{0, 0, 40, 40};
  for (const double sigma : {0.0, 0.7}) {
    const PixelResponse response(sigma);
    const Polygon circle = Tessellate({{19.3, 20.1}, 11.25, {}}, 400);
    EXPECT_NEAR(Sum(Rasterize(circle, response, area), area), M_PI * 11.25 * 11.25, 1e-4);
  }
}

TEST(AreaRasterTest, OrientationDoesNotMatterAndWeightsAddUp) {
  for (const double sigma : {0.0, 0.7}) {
    const PixelResponse response(sigma);
    const Polygon outer = RotatedSquare({10, 10.3}, 12, 0.4);
    Polygon inner = RotatedSquare({10.1, 10}, 5, 0.1);
    const Rect area{0, 0, 20, 20};
    AreaRaster nested(response, area);
    nested.Add(outer, 200);
    std::reverse(inner.begin(), inner.end());
    nested.Add(inner, -150);
    nested.Finish();
    const AreaRaster a = Rasterize(outer, response, area), b = Rasterize(inner, response, area);
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 20; ++x) {
        EXPECT_NEAR(nested.row(y)[x], 200 * a.row(y)[x] - 150 * b.row(y)[x], 1e-9);
      }
    }
    EXPECT_NEAR(a.row(10)[10], 1, kBlurred);
  }
}

double NormalIntegral2(double x, double sigma) {
  return x * 0.5 * std::erfc(-x / sigma * M_SQRT1_2) +
         sigma / std::sqrt(2 * M_PI) * std::exp(-0.5 * x * x / (sigma * sigma));
}

// Response of a pixel at distance d inside an axis-aligned edge.
double EdgeResponse(double d, double sigma) {
  return NormalIntegral2(d + 0.5, sigma) - NormalIntegral2(d - 0.5, sigma);
}

TEST(AreaRasterTest, BlurredRectangleEqualsClosedForm) {
  for (const double sigma : {0.002, 0.05, 0.3, 0.7, 2.0, 6.0}) {
    const PixelResponse response(sigma);
    const double x0 = 20.13, x1 = 27.4, y0 = 19.5, y1 = 31.77;
    const AreaRaster raster = Rasterize(Rectangle(x0, y0, x1, y1), response, {0, 0, 50, 50});
    for (int y = 0; y < 50; ++y) {
      for (int x = 0; x < 50; ++x) {
        const double expected = (EdgeResponse(x - x0, sigma) - EdgeResponse(x - x1, sigma)) *
                                (EdgeResponse(y - y0, sigma) - EdgeResponse(y - y1, sigma));
        ASSERT_NEAR(raster.row(y)[x], expected, kBlurred) << sigma << ": " << x << ", " << y;
      }
    }
  }
}

TEST(AreaRasterTest, BlurredSlantedEdgeEqualsIntegratedErrorFunction) {
  constexpr int kSamples = 40;
  for (const double sigma : {0.4, 0.7, 1.5}) {
    const PixelResponse response(sigma);
    for (const double angle : {0.0, 0.002, 0.5, M_PI / 4, 1.5, 2.5, 4.0}) {
      // A half plane: its other corners are far away.
      const double c = std::cos(angle), s = std::sin(angle);
      const auto at = [&](double u, double v) {
        return Point2{9.7 + u * c - v * s, 10.2 + u * s + v * c};
      };
      const Polygon half{at(0, -1000), at(2000, -1000), at(2000, 1000), at(0, 1000)};
      const AreaRaster raster = Rasterize(half, response, {0, 0, 20, 20});
      for (int y = 0; y < 20; ++y) {
        for (int x = 0; x < 20; ++x) {
          double sum = 0;
          for (int j = 0; j < kSamples; ++j) {
            for (int i = 0; i < kSamples; ++i) {
              const double px = x + (i + 0.5) / kSamples - 0.5 - 9.7;
              const double py = y + (j + 0.5) / kSamples - 0.5 - 10.2;
              sum += 0.5 * std::erfc(-(px * c + py * s) / sigma * M_SQRT1_2);
            }
          }
          // The error of the midpoint rule is up to 1e-4 at the smallest sigma.
          ASSERT_NEAR(raster.row(y)[x], sum / (kSamples * kSamples), 1e-4)
              << sigma << ", " << angle << ": " << x << ", " << y;
        }
      }
    }
  }
}

TEST(AreaRasterTest, RectangleEqualsCropOfLargerOne) {
  for (const double sigma : {0.0, 0.7, 3.0}) {
    const PixelResponse response(sigma);
    const Rect whole{-60, -60, 160, 160};
    const Polygon polygon{{-41.3, 8.2}, {12.7, -37.1}, {80.9, 21.4}, {30.2, 24.8}, {17.1, 66.3}};
    const AreaRaster reference = Rasterize(polygon, response, whole);
    for (const Rect& part : {Rect{0, 0, 20, 20}, Rect{-30, 10, 7, 40}, Rect{15, 21, 1, 1},
                             Rect{-60, 5, 100, 1}, Rect{10, -40, 1, 110}, Rect{60, 40, 9, 9}}) {
      const AreaRaster raster = Rasterize(polygon, response, part);
      for (int y = part.y; y < part.y + part.height; ++y) {
        for (int x = 0; x < part.width; ++x) {
          ASSERT_NEAR(raster.row(y)[x], reference.row(y)[x + part.x - whole.x],
                      sigma > 0 ? 2 * kBlurred : kExact)
              << sigma << ": " << x + part.x << ", " << y;
        }
      }
    }
  }
}

TEST(AreaRasterTest, FarCornersDoNotMatter) {
  for (const double sigma : {0.0, 0.7}) {
    const PixelResponse response(sigma);
    const Rect area{0, 0, 16, 16};
    const AreaRaster near = Rasterize(Rectangle(-50, -50, 8.3, 9.6), response, area);
    const AreaRaster far = Rasterize(Rectangle(-1e8, -1e8, 8.3, 9.6), response, area);
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 16; ++x) ASSERT_NEAR(near.row(y)[x], far.row(y)[x], kBlurred);
    }
    EXPECT_NEAR(near.row(0)[0], 1, kBlurred);
    EXPECT_NEAR(near.row(15)[0], 0, kBlurred);
  }
}

// Long edges, flat ones and others, that have no digit left for where they cross the rectangle.
TEST(AreaRasterTest, EdgesLongerThanADoubleHasDigits) {
  std::mt19937_64 random(1);
  const auto coordinate = [&](double low, double high) {
    const double digits = low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
    return std::pow(10, digits) * (random() % 2 == 0 ? 1 : -1);
  };
  for (const double sigma : {0.0, 0.7}) {
    const PixelResponse response(sigma);
    const Rect area{0, 0, 16, 16};
    for (int i = 0; i < 20000; ++i) {
      const double x = i % 2 == 0 ? 18 : 308, y = i % 4 < 2 ? 3 : x;
      AreaRaster raster(response, area);
      Polygon polygon;
      for (int k = 0; k < 3; ++k) polygon.push_back({coordinate(14, x), coordinate(0, y)});
      raster.Add(polygon, 1);
      raster.Finish();
      ASSERT_TRUE(std::isfinite(Sum(raster, area))) << sigma << ", " << i;
    }
  }
}

TEST(AreaRasterTest, CornersThatAreNoNumbers) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double values[] = {std::nan(""), kInfinity, -kInfinity, 1e308, -1e308, 3};
  for (const double sigma : {0.0, 0.7}) {
    const PixelResponse response(sigma);
    const Rect area{0, 0, 16, 16};
    for (const double x : values) {
      for (const double y : values) {
        for (const double z : values) {
          const AreaRaster raster = Rasterize({{x, y}, {z, -50}, {-50, z}}, response, area);
          ASSERT_TRUE(std::isfinite(Sum(raster, area))) << x << ", " << y << ", " << z;
        }
      }
    }
  }
}

}  // namespace
}  // namespace topotag
