#include "host/outline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "topotag/error.h"

namespace topotag {
namespace {

TEST(OutlineTest, OffsetMitresCornersAndCutsSharpOnes) {
  // An L: its offset by 1 is the L of the same corners, each a mitre.
  const Polygon l = {{0, 0}, {10, 0}, {10, 4}, {4, 4}, {4, 10}, {0, 10}};
  EXPECT_NEAR(SignedArea(OffsetOutwards(l, 1)), 12 * 6 + 6 * 6, 1e-9);
  // A needle of 10 to 1: without the cut its tip would reach out 20 units.
  const Polygon needle = {{0, -0.5}, {10, 0}, {0, 0.5}};
  double reach = 0;
  for (const Point2& p : OffsetOutwards(needle, 1)) reach = std::max(reach, p.x);
  EXPECT_NEAR(reach, 10 + 2.5, 1e-9);
}

TEST(OutlineTest, OffsetFillsBaysThatItCloses) {
  // A square with a bay 1 wide and 6 deep: an offset of 1 closes it, one of 0.2 does not.
  const Polygon bay = {{0, 0},   {10, 0},  {10, 10},  {5.5, 10},
                       {5.5, 4}, {4.5, 4}, {4.5, 10}, {0, 10}};
  EXPECT_NEAR(SignedArea(OffsetOutwards(bay, 1)), 12 * 12, 1e-9);
  EXPECT_NEAR(SignedArea(OffsetOutwards(bay, 0.2)), 10.4 * 10.4 - 0.6 * 6, 1e-9);
  // A bay with a narrow mouth: the hall behind it becomes a closed hole, which is filled.
  const Polygon hall = {{0, 0},  {20, 0}, {20, 20}, {10.5, 20}, {10.5, 16}, {16, 16},
                        {16, 4}, {4, 4},  {4, 16},  {9.5, 16},  {9.5, 20},  {0, 20}};
  EXPECT_NEAR(SignedArea(OffsetOutwards(hall, 1)), 22 * 22, 1e-9);
}

TEST(OutlineTest, OffsetOfADenseWavyOutlineKeepsItsDistance) {
  Polygon wavy;
  for (int i = 0; i < 900; ++i) {
    const double angle = 2 * M_PI * i / 900, radius = 10 + std::cos(9 * angle);
    wavy.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  for (const double distance : {0.05, 0.7, 3.0, 12.0}) {
    const Polygon offset = OffsetOutwards(wavy, distance);
    EXPECT_TRUE(IsSimple(offset));
    for (const Point2& p : offset) {
      EXPECT_FALSE(Contains(wavy, p));
      EXPECT_NEAR(DistanceToOutline(wavy, p), distance, 1e-3 * distance);
    }
  }
}

double LargestCoordinate(const Polygon& polygon) {
  double largest = 0;
  for (const Point2& p : polygon) largest = std::max({largest, std::abs(p.x), std::abs(p.y)});
  return largest;
}

// Needles a few roundings wide, whose edges turn back on themselves.
TEST(OutlineTest, OffsetOfNeedlesThatAreNextToNothing) {
  int reversals = 0;
  for (int i = 0; i < 2000; ++i) {
    const double left = 0.01 * (i % 997), x = 20 + 0.03 * i, y = 150 + std::fmod(0.7 * i, 100);
    double right = left;
    for (int k = 0; k <= i % 4; ++k) right = std::nextafter(right, 100);
    const Polygon needle = {{-100, -100}, {100, -100}, {100, 100}, {right, 100},
                            {x, y},       {left, 100}, {-100, 100}};
    if (!IsSimple(needle)) continue;
    ++reversals;
    const Polygon offset = OffsetOutwards(needle, 1);
    EXPECT_LT(LargestCoordinate(offset), 260) << i;
    EXPECT_NEAR(DistanceToOutline(offset, {x, y}), 1, 1e-6) << i;
    EXPECT_GT(SignedArea(offset), 202 * 202) << i;
  }
  EXPECT_GT(reversals, 100);
}

TEST(OutlineTest, OffsetOfANotchByNextToNothing) {
  const Polygon notch = {{-100, -100}, {100, -100},  {100, 100}, {1e-7, 100},
                         {0, 50},      {-1e-7, 100}, {-100, 100}};
  for (const double distance : {1e-320, 1e-300, 1e-100, 1e-10}) {
    EXPECT_NEAR(SignedArea(OffsetOutwards(notch, distance)), 200 * 200, 1e-4) << distance;
  }
}

TEST(OutlineTest, OffsetOfEdgesThatAreNextToNothing) {
  const Polygon polygon = {{-10, 0}, {0, 0}, {1e-200, 1e-200}, {10, 0}, {10, 10}, {-10, 10}};
  EXPECT_NEAR(SignedArea(OffsetOutwards(polygon, 1)), 22 * 12, 1e-9);
}

TEST(OutlineTest, OffsetThatIsNoOutlineIsRefused) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(OffsetOutwards({{0, 0}, {1e300, 0}, {0, 1e300}}, 1), Error);
  EXPECT_THROW(OffsetOutwards({{0, 0}, {kNan, 0}, {0, 9}}, 1), Error);
  EXPECT_THROW(OffsetOutwards({{0, 0}, {1e-160, 0}, {0, 1e-160}}, 1e-300), Error);
}

TEST(OutlineTest, SimplePolygons) {
  EXPECT_TRUE(IsSimple({{0, 0}, {2, 0}, {1, 1}}));
  EXPECT_TRUE(IsSimple({{0, 0}, {1, 0}, {2, 0}, {1, 1}}));
  EXPECT_FALSE(IsSimple({{0, 0}, {2, 0}}));
  EXPECT_FALSE(IsSimple({{0, 0}, {2, 2}, {2, 0}, {0, 2}}));                  // crosses
  EXPECT_FALSE(IsSimple({{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}));          // touches
  EXPECT_FALSE(IsSimple({{0, 0}, {4, 0}, {2, 0}, {2, 2}}));                  // turns back
  EXPECT_FALSE(IsSimple({{0, 0}, {2, 0}, {2, 0}, {1, 1}}));                  // repeats
  EXPECT_FALSE(IsSimple({{0, 0}, {4, 0}, {4, 2}, {3, 0}, {1, 0}, {0, 2}}));  // overlaps
}

}  // namespace
}  // namespace topotag
