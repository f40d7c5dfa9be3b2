#include "host/tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "fallback/scalar_backend.h"
#include "tests/marker_canvas.h"
#include "tests/random_image.h"

namespace topotag {
namespace {

TreeParams Default(std::vector<int> families = {3, 4, 5}) {
  TreeParams params;
  for (const int n : families) params.families.emplace_back(n);
  return params;
}

TreeParams Paper(std::vector<int> families = {3, 4, 5}) {
  TreeParams params = Default(std::move(families));
  params.tau = 0;
  params.baseline_reference = true;
  return params;
}

void Find(const Canvas& canvas, TopologyTree* tree) {
  scalar::ScalarBackend backend;
  Components components;
  backend.Label(canvas.Bits(), &components);
  tree->Find(components, &backend);
}

TopologyTree Find(const Canvas& canvas, const TreeParams& params) {
  TopologyTree tree(params);
  Find(canvas, &tree);
  return tree;
}

size_t CountCandidates(const Canvas& canvas, const TreeParams& params = Default()) {
  return Find(canvas, params).candidates().size();
}

// Candidate `index` is the marker: family, nodes in raster order with the holes of its ID, all
// areas but those changed by specks.
void ExpectMarker(const TopologyTree& tree, size_t index, const DrawnMarker& m, bool exact = true) {
  SCOPED_TRACE(testing::Message() << m.n << "x" << m.n << " ID " << m.id << ", unit " << m.unit);
  ASSERT_GT(tree.candidates().size(), index);
  const Candidate& candidate = tree.candidates()[index];
  EXPECT_EQ(candidate.family, Family(m.n));
  EXPECT_EQ(candidate.baseline, 0);
  ASSERT_EQ(candidate.node_count, m.n * m.n - 1);
  EXPECT_EQ(candidate.white.min_x, m.x);
  EXPECT_EQ(candidate.white.min_y, m.y);
  EXPECT_EQ(candidate.white.max_x, m.x + m.side() - 1);
  EXPECT_EQ(candidate.white.max_y, m.y + m.side() - 1);
  const Node* node = tree.nodes(candidate);
  for (int i = 0; i < candidate.node_count; ++i, ++node) {
    const int row = (i + 1) / m.n, col = (i + 1) % m.n;
    EXPECT_EQ(node->hole_count, i == 0 ? 2 : m.bit(row, col)) << "node " << i;
    EXPECT_EQ(node->black.min_x, m.node_x(i == 0 ? 0 : col)) << "node " << i;
    EXPECT_EQ(node->black.min_y, m.node_y(row)) << "node " << i;
    if (!exact) continue;
    EXPECT_EQ(node->black.area, m.area((i == 0 ? 15 : 9) - node->hole_count)) << "node " << i;
    for (int hole = 0; hole < node->hole_count; ++hole) {
      EXPECT_EQ(node->holes[static_cast<size_t>(hole)].area, m.area(1)) << "node " << i;
    }
  }
  if (!exact) return;
  const int nodes = 15 + 9 * (m.n * m.n - 2);
  EXPECT_EQ(candidate.white.area, m.area((4 * m.n + 1) * (4 * m.n + 1) - nodes));
}

TEST(TreeTest, MarkersOfAllFamiliesAndUnits) {
  Random random(1);
  for (int n = Family::kMinN; n <= Family::kMaxN; ++n) {
    for (const int unit : {1, 2, 3, 7}) {
      DrawnMarker m{n, 0, unit, random.Between(1, 40), random.Between(1, 40)};
      for (int bit = 0; bit < n * n - 2; ++bit) m.id = 2 * m.id + (random.Chance(50) ? 1 : 0);
      const TopologyTree tree = Find(Drawn(m), Default({3, 4, 5, 6, 7, 8}));
      ASSERT_EQ(tree.candidates().size(), 1U);
      ExpectMarker(tree, 0, m);
      EXPECT_TRUE(tree.doubts().empty());
      ExpectMarker(Find(Drawn(m), Paper({n})), 0, m);
    }
  }
}

TEST(TreeTest, BaselineWhereverItLies) {
  Canvas canvas = Drawn({4, 8390});
  const int popcount = 5;
  for (int turn = 0; turn < 4; ++turn, canvas = canvas.Turned()) {
    const TopologyTree tree = Find(canvas, Default());
    ASSERT_EQ(tree.candidates().size(), 1U);
    const Candidate& candidate = tree.candidates()[0];
    const Node* node = tree.nodes(candidate);
    int holes = 0;
    for (int i = 0; i < candidate.node_count; ++i) {
      EXPECT_EQ(node[i].hole_count == 2, i == candidate.baseline);
      EXPECT_TRUE(i == 0 || node[i - 1].component < node[i].component);
      holes += node[i].hole_count;
    }
    EXPECT_EQ(holes, popcount + 2);
    EXPECT_EQ(node[candidate.baseline].black.area, 13U * 36U);
  }
}

TEST(TreeTest, HolesAreListedLargestFirst) {
  const DrawnMarker m{3, 5};
  for (const int larger : {0, 1}) {
    Canvas canvas = Drawn(m);
    canvas.Fill(m.hole_x(0) + 2 * m.unit * larger, m.hole_y(0) - 1, m.unit, 1, true);
    const TopologyTree tree = Find(canvas, Default());
    ASSERT_EQ(tree.candidates().size(), 1U);
    const Node& baseline = tree.nodes(tree.candidates()[0])[0];
    EXPECT_EQ(baseline.holes[0].area, 42U);
    EXPECT_EQ(baseline.holes[0].min_x, m.hole_x(0) + 2 * m.unit * larger);
    EXPECT_EQ(baseline.holes[1].area, 36U);
  }
}

TEST(TreeTest, OnlyTheFamiliesAskedFor) {
  for (int n = 3; n <= 5; ++n) {
    const Canvas canvas = Drawn({n, 77});
    for (int asked = 3; asked <= 5; ++asked) {
      EXPECT_EQ(CountCandidates(canvas, Default({asked})), n == asked ? 1U : 0U) << n << asked;
      EXPECT_EQ(CountCandidates(canvas, Paper({asked})), n == asked ? 1U : 0U) << n << asked;
    }
  }
}

// A speck of `count` pixels: black between the rows, in a hole or in one of the baseline node's;
// white in a solid node, in the ring around a hole or in the baseline node.
Canvas WithSpeck(const DrawnMarker& m, const char* where, int count) {
  Canvas canvas = Drawn(m);
  switch (where[0]) {
    case 'w':
      canvas.Speck(m.node_x(0), m.node_y(1) - m.unit + 1, count, false, 60);
      break;
    case 'h':
      canvas.Speck(m.hole_x(0) + 1, m.hole_y(2) + 1, count, false, 12);
      break;
    case 'b':
      canvas.Speck(m.hole_x(0) + 2 * m.unit + 1, m.hole_y(0) + 1, count, false, 12);
      break;
    case 's':
      canvas.Speck(m.node_x(1) + 2, m.node_y(2) + 2, count, true, 12);
      break;
    case 'r':
      canvas.Speck(m.node_x(0) + 1, m.node_y(2) + 1, count, true, 18);
      break;
    default:
      canvas.Speck(m.node_x(0) + 1, m.node_y(0) + 1, count, true, 18);
  }
  return canvas;
}

// Up to which size, and not above it, errors are removed: below 30 % of what they are compared
// with.
TEST(TreeTest, SpecksUpToTheta1AreRemoved) {
  const DrawnMarker m{3, 4 + 32, 20};  // vertices 3 and 6 have holes: cells (1, 0) and (2, 0)
  const struct {
    const char* where;
    int largest;
  } table[] = {
      {"white area", 959},    // 0.3 x 8 x 400 = 960, of the smallest nodes: those with a hole
      {"hole", 92},           // 0.3 x (400 - 92) = 92.4
      {"baseline hole", 92},  //
      {"ring", 119},          // 0.3 x 400 = 120, of the node's own hole
      {"twin holes", 119},    // 0.3 x 400 = 120, of the baseline node's holes
  };
  for (const auto& t : table) {
    SCOPED_TRACE(t.where);
    for (const int count : {1, 9, t.largest / 2, t.largest}) {
      const TopologyTree tree = Find(WithSpeck(m, t.where, count), Default());
      ASSERT_EQ(tree.candidates().size(), 1U) << count;
      ExpectMarker(tree, 0, m, false);
    }
    EXPECT_EQ(CountCandidates(WithSpeck(m, t.where, t.largest + 1)), 0U);
  }
}

TEST(TreeTest, HolesOfAFiftiethOfTheirNodeAreHoles) {
  // 50 x 70 < 3600 - 70, 50 x 71 is not below 3600 - 71; 50 x 51 = 2601 - 51.
  const int table[][3] = {{20, 70, 0}, {20, 71, 1}, {17, 50, 0}, {17, 51, 1}};
  for (const auto& [unit, area, holes] : table) {
    const TopologyTree tree = Find(WithSpeck({3, 0, unit}, "solid node", area), Default());
    ASSERT_EQ(tree.candidates().size(), 1U);
    EXPECT_EQ(tree.nodes(tree.candidates()[0])[6].hole_count, holes) << area;
  }
}

// A third hole is compared with the second one, not with the first.
TEST(TreeTest, BaselineHolesOfDifferentSize) {
  const DrawnMarker m{3, 9, 20};
  for (const int third : {59, 60}) {
    Canvas canvas = WithSpeck(m, "twin holes", third);
    canvas.Fill(m.hole_x(0) + 2 * m.unit, m.hole_y(0), m.unit / 2, m.unit, false);
    EXPECT_EQ(CountCandidates(canvas), third < 60 ? 1U : 0U);
  }
}

TEST(TreeTest, AnyPlaceTakesASpeck) {
  const DrawnMarker m{3, 0x2a, 4, 4, 4};
  for (int y = m.y; y < m.y + m.side(); ++y) {
    for (int x = m.x; x < m.x + m.side(); ++x) {
      Canvas canvas = Drawn(m);
      canvas.Fill(x, y, 1, 1, !IsWhite(canvas.Bits(), x, y));
      const TopologyTree tree = Find(canvas, Default());
      ASSERT_EQ(tree.candidates().size(), 1U) << x << ", " << y;
      const Candidate& candidate = tree.candidates()[0];
      EXPECT_EQ(candidate.family, Family(3));
      // The pixel may be the first one of its node, and so change the order.
      for (int i = 0; i < candidate.node_count; ++i) {
        const Node& node = tree.nodes(candidate)[i];
        const int row = (node.black.min_y + m.unit - m.node_y(0)) / (4 * m.unit);
        const int col = (node.black.min_x + m.unit - m.node_x(0)) / (4 * m.unit);
        const bool baseline = row == 0 && col == 0;
        EXPECT_EQ(i == candidate.baseline, baseline) << x << ", " << y;
        EXPECT_EQ(node.hole_count, baseline ? 2 : m.bit(row, col)) << x << ", " << y;
      }
    }
  }
}

TEST(TreeTest, AsManySpecksAsTau) {
  for (const int tau : {0, 1, 2, 16}) {
    TreeParams params = Default({3});
    params.tau = tau;
    Canvas canvas = Drawn({3, 100});
    for (int specks = 0; specks <= tau; ++specks) {
      EXPECT_EQ(CountCandidates(canvas, params), 1U) << tau << ": " << specks;
      canvas.Fill(8 + 4 * specks, 8, 1, 1, false);
    }
    EXPECT_EQ(CountCandidates(canvas, params), 0U) << tau;
  }
}

TEST(TreeTest, PaperTakesNoSpeckInTheWhiteArea) {
  for (int n = 3; n <= 5; ++n) {
    const DrawnMarker m{n, 0};
    Canvas canvas = Drawn(m);
    EXPECT_EQ(CountCandidates(canvas, Paper({n})), 1U);
    canvas.Fill(m.x + 2, m.y + 2, 1, 1, false);
    EXPECT_EQ(CountCandidates(canvas, Paper({n})), 0U);
    // Within the range of all families it is an error like others, but behind the largest.
    EXPECT_EQ(CountCandidates(canvas, Paper()), n < 5 ? 1U : 0U);
  }
}

// A node of any size with its holes, each `side` pixels wide, in a row.
void DrawNode(int x, int y, int side, int holes, Canvas* canvas) {
  canvas->Fill(x, y, (2 * std::max(holes, 1) + 1) * side, 3 * side, false);
  for (int i = 0; i < holes; ++i) canvas->Fill(x + (2 * i + 1) * side, y + side, side, side, true);
}

// Where the surplus of a small family could be errors, the largest family that fits is taken.
TEST(TreeTest, LargestFamilyThatFits) {
  Canvas canvas(500, 200);
  canvas.Fill(1, 1, 498, 198, true);
  DrawNode(5, 5, 12, 2, &canvas);
  for (int i = 0; i < 7; ++i) DrawNode(5 + 50 * i, 80, 12, 1, &canvas);
  for (int i = 0; i < 7; ++i) DrawNode(5 + 50 * i, 150, 3, 0, &canvas);
  for (const auto& families : {Default({3, 4}), Default({4, 3}), Default({3, 4, 5})}) {
    const TopologyTree tree = Find(canvas, families);
    ASSERT_EQ(tree.candidates().size(), 1U);
    EXPECT_EQ(tree.candidates()[0].family, Family(4));
    EXPECT_EQ(tree.candidates()[0].node_count, 15);
  }
  const TopologyTree tree = Find(canvas, Default({3}));
  ASSERT_EQ(tree.candidates().size(), 1U);
  EXPECT_EQ(tree.candidates()[0].node_count, 8);
}

// Rows of nodes, each three times as large as the last, the baseline node at either end.
TEST(TreeTest, ReferenceAreaUnderPerspective) {
  for (const bool baseline_near : {false, true}) {
    Canvas canvas(400, 400);
    canvas.Fill(1, 1, 398, 398, true);
    const int far = 3, middle = 10, near = 30;  // sides of the nodes' holes
    DrawNode(10, 10, baseline_near ? near : far, 2, &canvas);
    DrawNode(200, 10, baseline_near ? near : far, 1, &canvas);
    for (int i = 0; i < 3; ++i) DrawNode(10 + 100 * i, 130, middle, 1, &canvas);
    for (int i = 0; i < 3; ++i) DrawNode(10 + 120 * i, 200, baseline_near ? far : near, 1, &canvas);
    EXPECT_EQ(CountCandidates(canvas, Default({3})), 1U);
    EXPECT_EQ(CountCandidates(canvas, Paper({3})), baseline_near ? 0U : 1U);
    // Errors are small against the far nodes: 0.3 x 72 by default, 0.3 x 117 for the paper.
    TreeParams paper = Paper({3});
    paper.tau = 1;
    Canvas removed = canvas, kept = canvas;
    removed.Speck(5, 390, 21, false, 7);
    kept.Speck(5, 390, 22, false, 7);
    EXPECT_EQ(CountCandidates(removed, Default({3})), 1U);
    EXPECT_EQ(CountCandidates(kept, Default({3})), 0U);
    if (baseline_near) continue;
    removed.Speck(5, 390, 35, false, 7);
    kept.Speck(5, 390, 36, false, 7);
    EXPECT_EQ(CountCandidates(removed, paper), 1U);
    EXPECT_EQ(CountCandidates(kept, paper), 0U);
  }
}

TEST(TreeTest, WhatIsNoMarker) {
  for (int n = 3; n <= 5; ++n) {
    const DrawnMarker m{n, 0x15};
    const int last = n - 1;
    const auto without = [&](auto change) {
      Canvas canvas = Drawn(m);
      change(&canvas);
      return CountCandidates(canvas) + CountCandidates(canvas, Default({n})) +
             CountCandidates(canvas, Paper());
    };
    EXPECT_EQ(without([&](Canvas*) {}), 3U);
    EXPECT_EQ(without([&](Canvas* c) {  // a node is missing
                c->Fill(m.node_x(last), m.node_y(last), 3 * m.unit, 3 * m.unit, true);
              }),
              0U);
    EXPECT_EQ(without([&](Canvas* c) {  // the baseline node is missing
                c->Fill(m.node_x(0), m.node_y(0), 5 * m.unit, 3 * m.unit, true);
              }),
              0U);
    EXPECT_EQ(without([&](Canvas* c) {  // one node more: the baseline node in two
                c->Fill(m.hole_x(0) + m.unit, m.node_y(0), m.unit, 3 * m.unit, true);
              }),
              0U);
    EXPECT_EQ(without([&](Canvas* c) {  // another node with two holes
                c->Fill(m.node_x(1) + 2, m.node_y(1) + 2, 4, 14, true);
                c->Fill(m.node_x(1) + 9, m.node_y(1) + 2, 4, 14, true);
                c->Fill(m.node_x(1) + 7, m.node_y(1), 1, 18, false);
              }),
              0U);
    EXPECT_EQ(without([&](Canvas* c) {  // no node with two holes
                c->Fill(m.hole_x(0) + 2 * m.unit, m.hole_y(0), m.unit, m.unit, false);
              }),
              0U);
    EXPECT_EQ(without([&](Canvas* c) {  // three holes
                c->Fill(m.node_x(0) + 13, m.hole_y(0), 4, 4, true);
              }),
              0U);
    EXPECT_EQ(without([&](Canvas* c) {  // something large in a hole: a fourth level
                c->Fill(m.hole_x(last) - 3, m.hole_y(last) - 3, 12, 12, true);
                c->Fill(m.hole_x(last), m.hole_y(last), 6, 6, false);
              }),
              0U);
    EXPECT_EQ(without([&](Canvas* c) {  // the white area is not closed: its border, a node apart
                c->Fill(m.node_x(last), m.node_y(last) + 3 * m.unit, 3 * m.unit, m.unit, false);
              }),
              0U);
  }
}

TEST(TreeTest, NodesWithoutHolesAreADoubt) {
  for (int n = 3; n <= 5; ++n) {
    const DrawnMarker m{n, 0};
    Canvas canvas = Drawn(m);
    canvas.Fill(m.hole_x(0), m.hole_y(0), 3 * m.unit, m.unit, false);
    const TopologyTree tree = Find(canvas, Default());
    EXPECT_TRUE(tree.candidates().empty());
    ASSERT_EQ(tree.doubts().size(), 1U);
    EXPECT_EQ(tree.doubts()[0].white.min_x, m.x);
    EXPECT_EQ(tree.doubts()[0].white.max_y, m.y + m.side() - 1);
    EXPECT_GT(tree.doubts()[0].root, 0U);
  }
}

// Doubts need four nodes of like size that cover enough of the white area, and not too much.
TEST(TreeTest, WhatIsADoubt) {
  const auto doubts = [](const std::vector<int>& areas, int width, int height) {
    Canvas canvas(width, height);
    canvas.Fill(1, 1, width - 2, height - 2, true);
    for (size_t i = 0; i < areas.size(); ++i) {
      canvas.Speck(3 + 35 * static_cast<int>(i), 3, areas[i], false, 33);
    }
    const TopologyTree tree = Find(canvas, Default());
    EXPECT_TRUE(tree.candidates().empty());
    return tree.doubts().size();
  };
  EXPECT_EQ(doubts({990, 990, 990, 990}, 150, 60), 1U);
  EXPECT_EQ(doubts({990, 990, 990}, 150, 60), 0U);
  // A twelfth of the largest is like it, less is not.
  EXPECT_EQ(doubts({660, 660, 660, 55}, 150, 60), 1U);
  EXPECT_EQ(doubts({660, 660, 660, 54}, 150, 60), 0U);
  // Of a white area of 148 x 98 pixels without them, 400 x 4 are 12 %; 450 x 4 are 14.2 %, and
  // 480 x 4 are 15.3 %.
  EXPECT_EQ(doubts({400, 400, 400, 400}, 150, 100), 0U);
  EXPECT_EQ(doubts({450, 450, 450, 450}, 150, 100), 0U);
  EXPECT_EQ(doubts({480, 480, 480, 480}, 150, 100), 1U);
  // 33 x 33 x 4 = 4356 are 319 % of what they leave of 143 x 40 pixels, and 289 % of what they
  // leave of 143 x 41.
  EXPECT_EQ(doubts({1089, 1089, 1089, 1089}, 145, 42), 0U);
  EXPECT_EQ(doubts({1089, 1089, 1089, 1089}, 145, 43), 1U);
}

TEST(TreeTest, MarkersInsideOtherThings) {
  // White paper, a black ring, its hole with a marker in it, and another marker beside the ring.
  Canvas canvas(420, 200);
  canvas.Fill(2, 2, 410, 190, true);
  canvas.Fill(10, 10, 150, 150, false);
  canvas.Fill(15, 15, 140, 140, true);
  canvas.Fill(20, 20, 130, 130, false);
  const DrawnMarker inside{4, 278, 6, 30, 30};
  Draw(inside, &canvas);
  canvas.Fill(240, 5, 130, 130, false);
  const DrawnMarker beside{3, 77, 6, 250, 12};
  Draw(beside, &canvas);
  const TopologyTree tree = Find(canvas, Default());
  ASSERT_EQ(tree.candidates().size(), 2U);
  ExpectMarker(tree, 0, beside);  // its first pixel comes first
  ExpectMarker(tree, 1, inside);
  EXPECT_LT(tree.candidates()[0].root, tree.candidates()[1].root);
}

// What lies in a hole makes the outer one no marker, whatever it is.
TEST(TreeTest, MarkerInAHoleOfAnother) {
  const DrawnMarker large{3, 0x7f, 30, 4, 4};
  Canvas canvas = Drawn(large);
  const DrawnMarker small{3, 5, 1, large.hole_x(2) + 8, large.hole_y(2) + 8};
  canvas.Fill(small.x - 5, small.y - 5, small.side() + 10, small.side() + 10, false);
  Draw(small, &canvas);
  const TopologyTree tree = Find(canvas, Default());
  ASSERT_EQ(tree.candidates().size(), 1U);
  ExpectMarker(tree, 0, small);
}

TEST(TreeTest, ManySpecksInAHoleAreErrorsToo) {
  const DrawnMarker m{3, 0x7f, 20, 20, 20};
  Canvas canvas = Drawn(m);
  for (int specks = 1; specks <= 16; ++specks) {
    canvas.Fill(m.hole_x(1) + 4 * (specks % 4) + 2, m.hole_y(1) + specks / 4 * 4 + 2, 1, 1, false);
    const TopologyTree tree = Find(canvas, Default());
    ASSERT_EQ(tree.candidates().size(), 1U);
    ExpectMarker(tree, 0, m, false);
  }
}

// Where noise hangs together in clusters of all sizes, near the percolation of either colour, a few
// look like a marker's white area; second looks at them cost little. Elsewhere there is none.
TEST(TreeTest, NoiseIsHardlyEverADoubt) {
  Random random(5);
  for (int density = 10; density <= 90; density += 5) {
    Canvas canvas(600, 500);
    for (int y = 0; y < 500; ++y) {
      for (int x = 0; x < 600; ++x) canvas.Fill(x, y, 1, 1, random.Chance(density));
    }
    const TopologyTree tree = Find(canvas, Default());
    int64_t area = 0;
    for (const Doubt& doubt : tree.doubts()) {
      area +=
          (doubt.white.max_x - doubt.white.min_x + 1) * (doubt.white.max_y - doubt.white.min_y + 1);
    }
    EXPECT_LE(area, density < 45 || density > 65 ? 0 : 600 * 500 / 10) << density;
    EXPECT_LE(tree.candidates().size(), density < 45 || density > 65 ? 0U : 5U) << density;
  }
}

TEST(TreeTest, KeepsNothingOfTheLastFrame) {
  const DrawnMarker m{4, 12345, 6, 30, 40};
  TopologyTree tree(Default());
  Canvas two(500, 200);
  Draw(m, &two);
  Draw({5, 7654321, 6, 200, 20}, &two);
  Canvas doubtful = Drawn(m);
  doubtful.Fill(m.hole_x(0), m.hole_y(0), 3 * m.unit, m.unit, false);
  for (int i = 0; i < 2; ++i) {
    Find(two, &tree);
    EXPECT_EQ(tree.candidates().size(), 2U);
    Find(doubtful, &tree);
    EXPECT_TRUE(tree.candidates().empty());
    EXPECT_EQ(tree.doubts().size(), 1U);
    Find(Canvas(5, 5), &tree);
    EXPECT_TRUE(tree.candidates().empty());
    EXPECT_TRUE(tree.doubts().empty());
    Find(Drawn(m), &tree);
    ASSERT_EQ(tree.candidates().size(), 1U);
    ExpectMarker(tree, 0, m);
  }
}

}  // namespace
}  // namespace topotag
