#include "host/outline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
