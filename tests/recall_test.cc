// Every ID of 3x3 and random IDs of the larger families, all inner shapes, any rotation, tilts to
// 60 degrees, node pitches from 12 px: found, with the right ID and nothing else.

#include <gtest/gtest.h>

#include <tuple>

#include "tests/scene_util.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

class RecallTest : public testing::TestWithParam<std::tuple<int, InnerShape>> {};

TEST_P(RecallTest, EveryMarkerIsFoundWithItsId) {
  const Family family(std::get<0>(GetParam()));
  const InnerShape shape = std::get<1>(GetParam());
  test::Random random(static_cast<uint64_t>(family.n()) * 10 + static_cast<uint64_t>(shape));
  Options options;
  options.families = {Family(3), Family(4), Family(5)};
  if (family.n() > 5) options.families.push_back(family);
  Detector detector(options);

  Scene scene;
  scene.camera = test::PinholeCamera(360, 360, 600);
  const uint64_t count = family.n() == 3 ? family.size() : family.n() <= 5 ? 1000 : 100;
  for (uint64_t i = 0; i < count; ++i) {
    SceneMarker marker;
    marker.design.family = family;
    marker.design.id = family.n() == 3 ? i : random.Below(family.size());
    marker.design.inner = shape;
    const double pitch = random.Uniform(12, 40 * 4.0 / family.n());
    const double z = test::DistanceForPitch(scene.camera, family, marker.tag_size, pitch);
    marker.t = {random.Uniform(-0.05, 0.05) * z, random.Uniform(-0.05, 0.05) * z, z};
    const double tilt = random.Uniform(0, 60);
    marker.R = random.Tilted(tilt * test::kDegree);
    scene.markers = {marker};
    scene.seed = i;
    const Image image = RenderScene(scene);
    const std::vector<Detection> found = detector.detect(image.view());
    ASSERT_EQ(found.size(), 1u) << "ID " << marker.design.id << " pitch " << pitch << " tilt "
                                << tilt << " case " << i;
    ASSERT_EQ(found[0].family, family) << "case " << i;
    ASSERT_EQ(found[0].id, marker.design.id) << "pitch " << pitch << " tilt " << tilt;
    const Detection truth = GroundTruth(scene, 0);
    for (int v = 0; v < family.vertex_count(); ++v) {
      ASSERT_LT(test::Distance(found[0].vertices[v], truth.vertices[v]), 0.3)
          << "vertex " << v << " case " << i << " pitch " << pitch << " tilt " << tilt;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(FamiliesAndShapes, RecallTest,
                         testing::Combine(testing::Range(3, 9),
                                          testing::Values(InnerShape::kSquare, InnerShape::kCircle,
                                                          InnerShape::kHexagon)),
                         [](const auto& info) {
                           return Family(std::get<0>(info.param)).name() + "_" +
                                  Name(std::get<1>(info.param));
                         });

}  // namespace
}  // namespace topotag
