#include "topotag/marker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "host/outline.h"
#include "tests/temporary_folder.h"
#include "topotag/error.h"

namespace topotag {
namespace {

constexpr InnerShape kInnerShapes[] = {InnerShape::kSquare, InnerShape::kCircle,
                                       InnerShape::kHexagon};
constexpr OuterShape kOuterShapes[] = {OuterShape::kSquare, OuterShape::kCircle,
                                       OuterShape::kButterfly};
constexpr int kManySegments = 20000;

std::string ErrorText(const MarkerDesign& design) {
  try {
    BuildMarkerGeometry(design);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "no error";
}

MarkerDesign Design(int n, uint64_t id, InnerShape inner = InnerShape::kSquare,
                    OuterShape outer = OuterShape::kSquare) {
  MarkerDesign design;
  design.family = Family(n);
  design.id = id;
  design.inner = inner;
  design.outer = outer;
  return design;
}

MarkerDesign PolygonDesign(Polygon polygon) {
  MarkerDesign design = Design(3, 0);
  design.outer = OuterShape::kPolygon;
  design.polygon = std::move(polygon);
  return design;
}

std::string Bits(Family family, uint64_t id) {
  std::string bits;
  for (int v = 2; v < family.vertex_count(); ++v) bits += IdBit(family, id, v) ? '1' : '0';
  return bits;
}

TEST(MarkerTest, IdBitsAreThePublishedOnes) {
  EXPECT_EQ(Bits(Family(4), 8390), "10000011000110");
  EXPECT_EQ(Bits(Family(4), 278), "00000100010110");
  EXPECT_EQ(Bits(Family(3), 46), "0101110");
  EXPECT_EQ(Bits(Family(8), uint64_t{1} << 61), "1" + std::string(61, '0'));
  EXPECT_EQ(Bits(Family(8), Family(8).size() - 1), std::string(62, '1'));
}

TEST(MarkerTest, ModelVerticesOf4x4) {
  const std::vector<Point2> expected = {{-6, -6}, {-4, -6}, {2, -6}, {6, -6}, {-6, -2}, {-2, -2},
                                        {2, -2},  {6, -2},  {-6, 2}, {-2, 2}, {2, 2},   {6, 2},
                                        {-6, 6},  {-2, 6},  {2, 6},  {6, 6}};
  EXPECT_EQ(ModelVertices(Family(4)), expected);
}

TEST(MarkerTest, ModelVerticesOfOddFamiliesStandAtTheCentre) {
  for (const int n : {3, 5, 7}) {
    const auto vertices = ModelVertices(Family(n));
    ASSERT_EQ(vertices.size(), static_cast<size_t>(n * n));
    EXPECT_EQ(vertices[n * n / 2], (Point2{0, 0}));
    EXPECT_EQ(vertices.back(), (Point2{2.0 * (n - 1), 2.0 * (n - 1)}));
  }
}

TEST(MarkerTest, NodesAndHolesFollowTheVertices) {
  for (int n = Family::kMinN; n <= Family::kMaxN; ++n) {
    const Family family(n);
    const uint64_t id = 0x5a5a93c71e0f2468u % family.size();
    const auto vertices = ModelVertices(family);
    const auto geometry = BuildMarkerGeometry(Design(n, id));
    ASSERT_EQ(geometry.nodes.size(), static_cast<size_t>(family.node_count()));
    ASSERT_EQ(geometry.nodes[0].size(), 2u);
    std::vector<Point2> holes = {vertices[0], vertices[1]};
    for (int v = 2; v < family.vertex_count(); ++v) {
      ASSERT_EQ(geometry.nodes[v - 1].size(), 1u);
      EXPECT_EQ(geometry.nodes[v - 1][0].center, vertices[v]);
      if (IdBit(family, id, v)) holes.push_back(vertices[v]);
    }
    ASSERT_EQ(geometry.holes.size(), holes.size());
    for (size_t i = 0; i < holes.size(); ++i) EXPECT_EQ(geometry.holes[i].center, holes[i]);
  }
}

TEST(MarkerTest, AreasOfNodesAndHoles) {
  const double node_area[] = {9, M_PI * 1.5 * 1.5, 4.5 * std::sqrt(3.0)};
  // Circles: two discs less the lens they share. Hexagons: less the two triangles they share.
  const double lens = 2 * 2.25 * std::acos(2 / 3.0) - std::sqrt(9.0 - 4);
  const double shared = 2 * std::sqrt(3.0) * std::pow(std::sqrt(3.0) - 1, 2);
  const double union_area[] = {15, 2 * node_area[1] - lens, 2 * node_area[2] - shared};
  for (int shape = 0; shape < 3; ++shape) {
    const auto geometry = BuildMarkerGeometry(Design(4, 278, kInnerShapes[shape]));
    EXPECT_NEAR(SignedArea(Tessellate(geometry.nodes[1][0], 64)), node_area[shape], 1e-12);
    EXPECT_NEAR(SignedArea(Tessellate(geometry.holes[0], 64)), node_area[shape] / 9, 1e-12);
    const Polygon whole = TessellateUnion(geometry.nodes[0], kManySegments);
    EXPECT_NEAR(SignedArea(whole), union_area[shape], 1e-6);
    EXPECT_TRUE(IsSimple(TessellateUnion(geometry.nodes[0], 64)));
    EXPECT_EQ(TessellateUnion(geometry.nodes[1], 64), Tessellate(geometry.nodes[1][0], 64));
  }
}

TEST(MarkerTest, TessellatedCirclesKeepTheirAreaForAnyNumberOfSides) {
  for (const int segments : {3, 4, 7, 64, 1001}) {
    const Polygon polygon = Tessellate({{5, -7}, 2.5, {}}, segments);
    ASSERT_EQ(polygon.size(), static_cast<size_t>(segments));
    EXPECT_NEAR(SignedArea(polygon), M_PI * 6.25, 1e-12);
  }
}

TEST(MarkerTest, UnionsOfCirclesMirrorThemselves) {
  const auto geometry = BuildMarkerGeometry(Design(3, 0, InnerShape::kCircle));
  for (const int segments : {12, 33, 64}) {
    const Polygon whole = TessellateUnion(geometry.nodes[0], segments);
    EXPECT_TRUE(IsSimple(whole));
    for (const Point2& p : whole) {
      const Point2 mirrored{2 * -3 - p.x, p.y};
      EXPECT_LT(DistanceToOutline(whole, mirrored), 1e-12);
    }
  }
}

TEST(MarkerTest, UnionOfSeparateOutlinesIsAnError) {
  EXPECT_THROW(TessellateUnion({{{0, 0}, 1, {}}, {{3, 0}, 1, {}}}, 64), Error);
}

TEST(MarkerTest, NodesKeepTheirDistances) {
  const double side = std::sqrt(3.0);
  const double apart[] = {1, 1, 4 - 2 * side};
  const double from_edge[] = {1, 1, 2.5 - side};
  const double around_hole[] = {1, 1, 1};
  for (int shape = 0; shape < 3; ++shape) {
    const Family family(4);
    const auto geometry = BuildMarkerGeometry(Design(4, family.size() - 1, kInnerShapes[shape]));
    std::vector<Polygon> nodes;
    for (const auto& node : geometry.nodes) nodes.push_back(TessellateUnion(node, 720));
    double nearest = 100, edge = 100, hole = 100;
    for (size_t i = 0; i < nodes.size(); ++i) {
      edge = std::min(edge, DistanceBetween(nodes[i], geometry.white.points));
      for (size_t j = 0; j < i; ++j)
        nearest = std::min(nearest, DistanceBetween(nodes[i], nodes[j]));
      // Holes 0 and 1 stand in node 0, and hole i + 1 in node i.
      const Polygon inside = Tessellate(geometry.holes[i + 1], 720);
      EXPECT_TRUE(Contains(nodes[i], inside[0]));
      hole = std::min(hole, DistanceBetween(nodes[i], inside));
    }
    EXPECT_NEAR(nearest, apart[shape], 1e-4);
    EXPECT_NEAR(edge, from_edge[shape], 1e-4);
    EXPECT_NEAR(hole, around_hole[shape], 1e-4);
  }
}

TEST(MarkerTest, HexagonsPointAlongX) {
  const auto geometry = BuildMarkerGeometry(Design(3, 0, InnerShape::kHexagon));
  const Polygon& node = geometry.nodes.back()[0].points;
  const auto [left, right] =
      std::minmax_element(node.begin(), node.end(), [](Point2 a, Point2 b) { return a.x < b.x; });
  EXPECT_NEAR(right->x - left->x, 2 * std::sqrt(3.0), 1e-12);
  EXPECT_DOUBLE_EQ(left->y, 4);
  const auto [top, bottom] =
      std::minmax_element(node.begin(), node.end(), [](Point2 a, Point2 b) { return a.y < b.y; });
  EXPECT_DOUBLE_EQ(bottom->y - top->y, 3);
}

TEST(MarkerTest, WhiteAreas) {
  const auto square = BuildMarkerGeometry(Design(5, 0));
  EXPECT_DOUBLE_EQ(SignedArea(square.white.points), 21 * 21);
  const auto circle = BuildMarkerGeometry(Design(5, 0, InnerShape::kSquare, OuterShape::kCircle));
  EXPECT_DOUBLE_EQ(circle.white.radius, 21 / std::sqrt(2.0));
}

TEST(MarkerTest, ButterflyIsASymmetricOutlineAroundTheWholeSquare) {
  const auto geometry =
      BuildMarkerGeometry(Design(4, 0, InnerShape::kSquare, OuterShape::kButterfly));
  const Polygon& butterfly = geometry.white.points;
  EXPECT_TRUE(IsSimple(butterfly));
  EXPECT_GT(SignedArea(butterfly), 17 * 17);
  const Polygon square = {{-8.5, -8.5}, {8.5, -8.5}, {8.5, 8.5}, {-8.5, 8.5}};
  EXPECT_GT(DistanceBetween(butterfly, square), 0.5);
  EXPECT_TRUE(Contains(butterfly, square[0]));
  for (const Point2& p : butterfly) {
    EXPECT_LT(DistanceToOutline(butterfly, {-p.x, p.y}), 1e-12);
    EXPECT_FALSE(Contains(square, p));
  }
}

TEST(MarkerTest, FrameAndPaperFollowTheOuterShape) {
  for (const OuterShape outer : kOuterShapes) {
    MarkerDesign design = Design(3, 0, InnerShape::kCircle, outer);
    design.frame = 1.5;
    design.margin = 2;
    const auto geometry = BuildMarkerGeometry(design);
    ASSERT_EQ(geometry.frame.size(), 1u);
    ASSERT_EQ(geometry.paper.size(), 1u);
    const Polygon white = Tessellate(geometry.white, kManySegments);
    const Polygon frame = Tessellate(geometry.frame[0], 300);
    const Polygon paper = Tessellate(geometry.paper[0], 300);
    EXPECT_TRUE(IsSimple(frame));
    EXPECT_TRUE(IsSimple(paper));
    for (const Point2& p : frame) {
      EXPECT_FALSE(Contains(white, p));
      EXPECT_GT(DistanceToOutline(white, p), 1.5 - 1e-3);
      EXPECT_LT(DistanceToOutline(white, p), 1.5 * 1.42);
    }
    for (const Point2& p : paper) EXPECT_GT(DistanceToOutline(white, p), 3.5 - 1e-3);
    double right = 0;
    for (const Point2& p : Tessellate(geometry.paper[0], 4)) right = std::max(right, p.x);
    if (outer == OuterShape::kSquare) {
      EXPECT_DOUBLE_EQ(right, 10);
      EXPECT_DOUBLE_EQ(SignedArea(frame), 16 * 16);
    }
    if (outer == OuterShape::kCircle) {
      EXPECT_DOUBLE_EQ(geometry.frame[0].radius, geometry.white.radius + 1.5);
      EXPECT_DOUBLE_EQ(geometry.max.x, geometry.white.radius + 3.5);
    }
    EXPECT_NEAR(geometry.max.x, -geometry.min.x, 1e-9);
  }
}

TEST(MarkerTest, NoFrameAndNoMargin) {
  MarkerDesign design = Design(3, 0);
  design.frame = 0;
  auto geometry = BuildMarkerGeometry(design);
  EXPECT_TRUE(geometry.frame.empty());
  EXPECT_TRUE(geometry.paper.empty());
  EXPECT_EQ(geometry.min, (Point2{-6.5, -6.5}));
  design.margin = 1;
  geometry = BuildMarkerGeometry(design);
  EXPECT_TRUE(geometry.frame.empty());
  ASSERT_EQ(geometry.paper.size(), 1u);
  EXPECT_EQ(geometry.max, (Point2{7.5, 7.5}));
}

TEST(MarkerTest, PolygonsAreTakenInEitherOrientation) {
  const Polygon outline = {{-8, -7}, {8, -7}, {7, 9}, {-7, 9}};
  const Polygon backwards(outline.rbegin(), outline.rend());
  Polygon closed = outline;
  closed.push_back(outline[0]);
  const auto a = BuildMarkerGeometry(PolygonDesign(outline));
  const auto b = BuildMarkerGeometry(PolygonDesign(backwards));
  const auto c = BuildMarkerGeometry(PolygonDesign(closed));
  EXPECT_GT(SignedArea(a.white.points), 0);
  EXPECT_DOUBLE_EQ(SignedArea(a.white.points), SignedArea(b.white.points));
  EXPECT_EQ(a.white.points, c.white.points);
  EXPECT_NEAR(SignedArea(a.frame[0].points), SignedArea(b.frame[0].points), 1e-9);
  EXPECT_NEAR(a.max.y, 10, 1e-9);
}

TEST(MarkerTest, PolygonErrors) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(ErrorText(PolygonDesign({{0, 0}, {1, 1}})),
            "polygon has 2 points: at least 3 are needed");
  EXPECT_EQ(ErrorText(PolygonDesign({})), "polygon has 0 points: at least 3 are needed");
  EXPECT_EQ(ErrorText(PolygonDesign({{-9, -9}, {nan, -9}, {9, 9}})),
            "polygon point (nan, -9) is not within +-10000 units");
  EXPECT_EQ(ErrorText(PolygonDesign({{-9, -9}, {1e300, -9}, {9, 9}})),
            "polygon point (1e+300, -9) is not within +-10000 units");
  EXPECT_EQ(ErrorText(PolygonDesign({{-9, -9}, {9, 9}, {9, -9}, {-9, 9}})),
            "polygon is not simple: its outline touches or crosses itself");
  EXPECT_EQ(ErrorText(PolygonDesign({{20, 20}, {30, 20}, {30, 30}})),
            "polygon does not contain the node at (-4, -4)");
  // The nodes of 3x3 reach out to 5.5.
  EXPECT_EQ(ErrorText(PolygonDesign({{-5.9, -7}, {7, -7}, {7, 7}, {-5.9, 7}})),
            "polygon leaves 0.4 units around the node at (-4, -4): at least 0.5 is needed");
  EXPECT_EQ(ErrorText(PolygonDesign({{-6, -6}, {6, -6}, {6, 6}, {-6, 6}})), "no error");
  // A slit that ends in the middle of a node, away from its outline.
  EXPECT_EQ(ErrorText(PolygonDesign(
                {{-7, -7}, {7, -7}, {7, 7}, {4.2, 7}, {4.1, 3.9}, {4.0, 7}, {-7, 7}})),
            "polygon leaves 0 units around the node at (4, 4): at least 0.5 is needed");
  EXPECT_EQ(ErrorText(PolygonDesign(Polygon(5000))),
            "polygon has 4999 points: at most 4000 are allowed");
}

TEST(MarkerTest, IdsAndWidthsOutOfRange) {
  EXPECT_EQ(ErrorText(Design(4, 16384)), "ID 16384 is out of range for family 4x4: 0 .. 16383");
  EXPECT_EQ(ErrorText(Design(3, 128)), "ID 128 is out of range for family 3x3: 0 .. 127");
  EXPECT_EQ(ErrorText(Design(8, uint64_t{1} << 62)),
            "ID 4611686018427387904 is out of range for family 8x8: 0 .. 4611686018427387903");
  for (const double width : {-0.1, std::nan(""), std::numeric_limits<double>::infinity()}) {
    MarkerDesign design = Design(4, 0);
    design.frame = width;
    EXPECT_NE(ErrorText(design).find("frame width"), std::string::npos) << width;
    design.frame = 1;
    design.margin = width;
    EXPECT_NE(ErrorText(design).find("margin width"), std::string::npos) << width;
  }
}

TEST(MarkerTest, OneVertexIsOneOfAll) {
  for (int n = Family::kMinN; n <= Family::kMaxN; ++n) {
    const std::vector<Point2> all = ModelVertices(Family(n));
    ASSERT_EQ(all.size(), static_cast<size_t>(n * n));
    for (int i = 0; i < n * n; ++i) EXPECT_EQ(ModelVertex(Family(n), i), all[i]) << n << " " << i;
  }
}

TEST(MarkerTest, ShapeNames) {
  for (const InnerShape shape : kInnerShapes) EXPECT_EQ(ParseInnerShape(Name(shape)), shape);
  EXPECT_STREQ(Name(OuterShape::kSquare), "square");
  EXPECT_STREQ(Name(OuterShape::kCircle), "circle");
  EXPECT_STREQ(Name(OuterShape::kButterfly), "butterfly");
  EXPECT_STREQ(Name(OuterShape::kPolygon), "polygon");
  EXPECT_THROW(ParseInnerShape("triangle"), Error);
  EXPECT_THROW(ParseInnerShape(""), Error);
}

class PolygonFileTest : public testing::Test {
 protected:
  void Write(const std::string& text) { std::ofstream(path_, std::ios::binary) << text; }

  std::string ErrorOf(const std::string& path, ErrorCode code) {
    try {
      ReadPolygon(path);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code);
      return error.what();
    }
    return "no error";
  }

  const test::TemporaryFolder folder_;
  const std::string path_ = (folder_.path() / "polygon.txt").string();
};

TEST_F(PolygonFileTest, ReadsPointsCommentsAndBlankLines) {
  Write("# outline\n\n-1.5 2\r\n  3e1\t-4 # last but one\n0 0");
  EXPECT_EQ(ReadPolygon(path_), (std::vector<Point2>{{-1.5, 2}, {30, -4}, {0, 0}}));
}

TEST_F(PolygonFileTest, NamesFileAndLine) {
  for (const std::string line : {"1", "1 2 3", "1,2", "a b", "1 nan", "inf 2", "1 2x"}) {
    Write("0 0\n" + line + "\n");
    EXPECT_EQ(ErrorOf(path_, ErrorCode::kParse),
              path_ + ":2: expected two numbers 'x y', got '" + line + "'");
  }
  Write("# nothing\n");
  EXPECT_EQ(ErrorOf(path_, ErrorCode::kParse), path_ + ": the file holds no point");
}

TEST_F(PolygonFileTest, NamesUnreadableFiles) {
  EXPECT_EQ(ErrorOf(path_, ErrorCode::kFile),
            "cannot read polygon file '" + path_ + "': No such file or directory");
  EXPECT_EQ(ErrorOf("/dev/zero", ErrorCode::kFile),
            "cannot read polygon file '/dev/zero': not a regular file");
  EXPECT_EQ(ErrorOf(testing::TempDir(), ErrorCode::kFile),
            "cannot read polygon file '" + testing::TempDir() + "': Is a directory");
}

}  // namespace
}  // namespace topotag
