// Markers of which something covers a part, joins nodes or cuts them: read where every node can be
// seen, with hidden nodes marked where that is asked for, and never with a wrong ID.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "host/homography.h"
#include "tests/scene_util.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

constexpr int kSize = 360;
constexpr double kBlur = 0.7;

struct Frame {
  Family family{4};
  uint64_t id = 0;
  double unit = 0;  // pixels
  Detection truth;
  Homography to_tag;
  Scene scene;
  Image image;
};

Frame MakeFrame(int n, test::Random* random) {
  Frame frame;
  frame.family = Family(n);
  frame.id = random->Below(frame.family.size());
  Scene& scene = frame.scene;
  scene.camera = test::PinholeCamera(kSize, kSize, 1.6 * kSize);
  SceneMarker marker;
  marker.design.family = frame.family;
  marker.design.id = frame.id;
  marker.design.inner = random->Below(2) == 0 ? InnerShape::kSquare : InnerShape::kCircle;
  const double pitch = random->Uniform(16, 34);
  frame.unit = pitch / 4;
  marker.t[2] = test::DistanceForPitch(scene.camera, frame.family, marker.tag_size, pitch);
  marker.R = random->Tilted(random->Uniform(0, 40) * test::kDegree);
  scene.markers = {marker};
  scene.seed = random->Below(1 << 30);
  frame.image = RenderScene(scene);
  frame.truth = GroundTruth(scene, 0);
  Homography map;
  SquareToQuad(frame.family.white_side() / 2.0, frame.truth.corners.data(), &map);
  Invert(map, &frame.to_tag);
  return frame;
}

// Paints where `inside`, a signed distance in units, is positive.
void Paint(const std::function<double(Point2)>& inside, double level, Frame* frame) {
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const auto at = [&](double dx, double dy) {
        return inside(frame->to_tag.Map({x + dx, y + dy}));
      };
      const double d = at(0, 0);
      if (d < -2) continue;
      const double slope = std::max(std::hypot(at(1, 0) - d, at(0, 1) - d), 1e-6);
      const double cover = 0.5 * std::erfc(-d / slope / kBlur / M_SQRT2);
      uint8_t& pixel = frame->image.row(y)[x];
      pixel = static_cast<uint8_t>(std::lround(pixel * (1 - cover) + cover * level));
    }
  }
}

// Covers a part of the frame's outer side: from the left, right, top, bottom of the marker.
void Cover(int side, double part, double level, Frame* frame) {
  const double half = frame->family.white_side() / 2.0 + 1;
  const double edge = half - 2 * half * part;
  Paint(
      [=](Point2 p) {
        const double reach = side == 0 ? -p.x : side == 1 ? p.x : side == 2 ? -p.y : p.y;
        return reach - edge;
      },
      level, frame);
}

// The ID as far as it is known.
void ExpectRight(const Frame& frame, const std::vector<Detection>& found) {
  for (const Detection& d : found) {
    EXPECT_EQ(d.family, frame.family);
    EXPECT_EQ(d.id, frame.id & ~d.unknown_bits);
    for (int v = 0; v < frame.family.vertex_count(); ++v) {
      // Hidden ones follow from the others, which may all lie on one side.
      EXPECT_LT(test::Distance(d.vertices[v], frame.truth.vertices[v]),
                (d.unknown_bits == 0 ? 0.5 : 1) * frame.unit)
          << "vertex " << v;
    }
  }
}

class OcclusionTest : public testing::TestWithParam<int> {};

TEST_P(OcclusionTest, ATenthIsReadFromEverySide) {
  Detector detector;
  test::Random random(static_cast<uint64_t>(GetParam()));
  int missed = 0;
  for (int i = 0; i < 60; ++i) {
    Frame frame = MakeFrame(GetParam(), &random);
    const int side = i % 4;
    const double level = (const double[]){12, 100, 225}[i / 4 % 3];
    Cover(side, 0.1, level, &frame);
    const std::vector<Detection> found = detector.detect(frame.image.view());
    ExpectRight(frame, found);
    const bool is_read = found.size() == 1 && found[0].unknown_bits == 0;
    missed += !is_read;
  }
  // A white cover that reaches nodes of 5x5 may leave too little of their bodies.
  EXPECT_LE(missed, GetParam() == 5 ? 3 : 0);
}

TEST_P(OcclusionTest, NothingIsReadWrong) {
  Options options;
  options.hidden_nodes = 16;
  Detector detector(options);
  test::Random random(static_cast<uint64_t>(GetParam()) + 10);
  int partial = 0;
  for (int i = 0; i < 160; ++i) {
    Frame frame = MakeFrame(GetParam(), &random);
    const double level = random.Uniform(5, 240), part = random.Uniform(0.05, 0.45);
    Cover(i % 4, part, level, &frame);
    const std::vector<Detection> found = detector.detect(frame.image.view());
    ExpectRight(frame, found);
    partial += found.size() == 1 && found[0].unknown_bits != 0;
  }
  EXPECT_GT(partial, GetParam() == 3 ? 0 : 20);
}

TEST_P(OcclusionTest, SpotsAreCorrected) {
  Detector detector;
  test::Random random(static_cast<uint64_t>(GetParam()) + 20);
  int read = 0;
  constexpr int kFrames = 60;
  for (int i = 0; i < kFrames; ++i) {
    Frame frame = MakeFrame(GetParam(), &random);
    // A quarter of a node, across the gap between two nodes or on the frame.
    const int n = GetParam();
    const int row = 1 + static_cast<int>(random.Below(static_cast<uint64_t>(n - 1)));
    const int col = static_cast<int>(random.Below(static_cast<uint64_t>(n)));
    const Point2 center{4.0 * col - 2 * (n - 1) + 2,
                        4.0 * row - 2 * (n - 1) + random.Uniform(-0.7, 0.7)};
    Paint(
        [&](Point2 p) {
          return 0.75 - std::max(std::abs(p.x - center.x), std::abs(p.y - center.y));
        },
        20, &frame);
    const std::vector<Detection> found = detector.detect(frame.image.view());
    ExpectRight(frame, found);
    read += found.size() == 1;
  }
  // Of 3x3, two joined nodes may leave too few others to find the grid by.
  EXPECT_GE(read, GetParam() == 3 ? kFrames / 2 : kFrames - 2);
}

INSTANTIATE_TEST_SUITE_P(Families, OcclusionTest, testing::Values(3, 4, 5));

// A right column that is covered wholly.
Frame HiddenColumn(test::Random* random) {
  Frame frame = MakeFrame(4, random);
  Cover(1, 0.24, 12, &frame);
  return frame;
}

TEST(HiddenNodesTest, AreMarkedWhereTheyAreAllowed) {
  test::Random random(1);
  Options options;
  options.camera = test::PinholeCamera(kSize, kSize, 1.6 * kSize);
  options.tag_size = 0.05;
  Detector strict(options);
  options.hidden_nodes = 4;
  Detector detector(options);
  for (int i = 0; i < 10; ++i) {
    const Frame frame = HiddenColumn(&random);
    EXPECT_TRUE(strict.detect(frame.image.view()).empty());
    const std::vector<Detection> found = detector.detect(frame.image.view());
    ASSERT_EQ(found.size(), 1u);
    // Vertices 3, 7, 11, 15 of 16; vertex 2 is bit 13.
    EXPECT_EQ(found[0].unknown_bits, 0x1111u);
    ExpectRight(frame, found);
    ASSERT_TRUE(found[0].pose);
    EXPECT_LT(test::Distance(found[0].pose->t, frame.scene.markers[0].t), 0.003);
  }
}

TEST(HiddenNodesTest, IdsInUseTellThem) {
  test::Random random(2);
  for (int i = 0; i < 6; ++i) {
    const Frame frame = HiddenColumn(&random);
    const auto detect = [&](std::vector<uint64_t> ids) {
      Options options;
      options.hidden_nodes = 4;
      options.ids[4] = std::move(ids);
      return Detector(options).detect(frame.image.view());
    };
    const uint64_t id = frame.id;
    const std::vector<Detection> only = detect({id ^ 2, id, id ^ 0x2000});
    ASSERT_EQ(only.size(), 1u);
    EXPECT_EQ(only[0].id, id);
    EXPECT_EQ(only[0].unknown_bits, 0u);
    const std::vector<Detection> two = detect({id ^ 1, id});
    ASSERT_EQ(two.size(), 1u);
    EXPECT_EQ(two[0].unknown_bits, 0x1111u);
    EXPECT_TRUE(detect({id ^ 2, id ^ 0x2000}).empty());
  }
}

// On a white area more dark spots, with and without holes, than any marker has nodes.
TEST(HiddenNodesTest, SpotsInRowsAreNoMarker) {
  constexpr int kPitch = 22, kSpot = 14;
  Image image(kSize, kSize);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const bool is_area = std::min({x, y, kSize - 1 - x, kSize - 1 - y}) > 6;
      const int u = (x - 14) % kPitch, v = (y - 14) % kPitch;
      const bool is_spot = x >= 14 && y >= 14 && u < kSpot && v < kSpot;
      const bool is_hole = u / 5 == 1 && v / 5 == 1 && (x / kPitch + y / kPitch) % 2 == 0;
      image.row(y)[x] = is_area && (!is_spot || is_hole) ? 215 : 30;
    }
  }
  Options options;
  options.hidden_nodes = 3;
  EXPECT_TRUE(Detector(options).detect(image.view()).empty());
}

TEST(IdsInUseTest, OthersAreNotReported) {
  test::Random random(3);
  const Frame frame = MakeFrame(4, &random);
  Options options;
  options.ids[4] = {frame.id ^ 1};
  EXPECT_TRUE(Detector(options).detect(frame.image.view()).empty());
  options.ids[4].push_back(frame.id);
  EXPECT_EQ(Detector(options).detect(frame.image.view()).size(), 1u);
  options.ids.erase(4);
  options.ids[3] = {0};
  EXPECT_EQ(Detector(options).detect(frame.image.view()).size(), 1u);
}

TEST(IdsInUseTest, BadListsAreErrors) {
  const auto fails = [](int n, std::vector<uint64_t> ids) {
    Options options;
    options.ids[n] = std::move(ids);
    EXPECT_THROW(Detector{options}, Error);
  };
  fails(9, {0});
  fails(4, {});
  fails(4, {1, 16384});
  Options options;
  options.hidden_nodes = -1;
  EXPECT_THROW(Detector{options}, Error);
}

}  // namespace
}  // namespace topotag
