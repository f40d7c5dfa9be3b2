// What the benchmarks measure is what they say: every system finds its own markers in every scene.
#include <gtest/gtest.h>

#include "bench/accuracy_cells.h"
#include "bench/comparison.h"
#include "bench/hard_conditions.h"
#include "bench/range_runs.h"
#include "bench/scenes.h"
#include "bench/timing.h"

namespace topotag::bench {
namespace {

TEST(BenchTest, SpreadIsOfSortedValues) {
  std::vector<double> values;
  for (int i = 200; i >= 1; --i) values.push_back(i);
  const Spread many = SpreadOf(values);
  EXPECT_EQ(many.min, 1);
  EXPECT_EQ(many.median, 100.5);
  EXPECT_EQ(many.p99, 198);
  const Spread one = SpreadOf({7});
  EXPECT_EQ(one.min, 7);
  EXPECT_EQ(one.median, 7);
  EXPECT_EQ(one.p99, 7);
  EXPECT_EQ(SpreadOf({}).p99, 0);
}

TEST(BenchTest, EveryBackendIsMeasuredOrMissing) {
  const Setups setups = FindSetups({1, 2});
  ASSERT_FALSE(setups.available.empty());
  EXPECT_EQ(setups.available[0].name, "scalar");
  size_t backends = setups.missing.size();
  for (const auto& setup : setups.available) backends += setup.threads == 1;
  EXPECT_EQ(backends, 3u);
  for (const auto& setup : setups.available) {
    EXPECT_TRUE(setup.backend != BackendKind::kScalar || setup.threads == 1);
  }
}

TEST(BenchTest, MeasuresAsManyFramesAsAsked) {
  const BenchScene scene = MakeScene(SceneKind::kMarkers, {640, 480}, {});
  const Image frame = RenderTopoTags(scene);
  const ColdFrames frames(frame.view(), 3 * 640 * 480);
  EXPECT_EQ(frames.views().size(), 4u);
  for (const Measured& measured :
       Measure(FindSetups({1, 2}).available, SceneOptions(scene), frames.views(), {0, 21, 21})) {
    EXPECT_EQ(measured.frames, 21u) << measured.setup.name;
    EXPECT_EQ(measured.markers, 20u) << measured.setup.name;
    EXPECT_GT(measured.stages[kTotal].min, 0) << measured.setup.name;
  }
}

void ExpectAllFound(const BenchScene& scene, const std::string& name) {
  Comparison comparison(scene, FindSetups({1, 2}).available, 1);
  comparison.Round();
  for (const Contestant& contestant : comparison.contestants()) {
    EXPECT_EQ(contestant.expected, scene.scene.markers.size());
    EXPECT_EQ(contestant.found, contestant.expected) << contestant.name << ", " << name;
    EXPECT_EQ(contestant.wrong, 0u) << contestant.name << ", " << name;
  }
}

TEST(BenchTest, EverySystemFindsItsOwnMarkers) {
  const Photos photos = LoadPhotos("");
  for (const FrameSize size : {FrameSize{640, 480}, FrameSize{1280, 960}}) {
    for (const SceneKind kind : kSceneKinds) {
      ExpectAllFound(MakeScene(kind, size, photos), Name(size) + " " + Name(kind));
    }
  }
  ExpectAllFound(MakeCrowd(200), "crowd");
}

TEST(AccuracyBenchTest, EverySystemSeesThePoseThatWasRendered) {
  const AccuracyCell cell = AccuracyBench(false).Measure({Family(4), 0.3, 30}, 2, 1);
  ASSERT_EQ(cell.bounds.size(), 2u);
  for (const PoseErrors& system : cell.systems) {
    ASSERT_EQ(system.frames.size(), 2u) << system.name;
    for (const auto& error : system.frames) {
      // A build without OpenCV's calib3d has no IPPE.
      if (!error && system.name.find("IPPE") != std::string::npos) continue;
      ASSERT_TRUE(error) << system.name;
      EXPECT_LT(error->position, 1e-3) << system.name;
      EXPECT_LT(error->rotation, 0.5 * test::kDegree) << system.name;
      EXPECT_EQ(error->mahalanobis2 > 0, system.ours) << system.name;
    }
  }
}

TEST(AccuracyBenchTest, OwnPoseOfArucoIsNone) {
  for (const auto& peer : MakeRefinedAruco()) {
    EXPECT_FALSE(peer->OwnPose(0, Camera(), 1)) << peer->name();
  }
}

TEST(RangeBenchTest, CountsWhatIsFoundAndWhatIsWrong) {
  Options options;
  options.threads = 1;
  const RangeRun near = RangeBench(options).Measure("wall", {}, 0, {0.5, 20}, 2);
  ASSERT_GE(near.systems.size(), 3u);
  for (const std::vector<Recall>& recall : near.recall) {
    EXPECT_EQ(recall[0].frames, 2);
    EXPECT_EQ(recall[0].found, 2);
    EXPECT_EQ(recall[0].wrong, 0);
    EXPECT_EQ(recall[1].frames, 2);
    EXPECT_EQ(recall[1].found, 0);
  }
}

TEST(HardConditionsTest, EachChangesTheFrame) {
  const View view{Family(4), 0.4, 30};
  const Image plain = RenderScene(MakeView(view, 2));
  const std::vector<HardCondition> conditions = HardConditions();
  for (size_t i = 1; i < conditions.size(); ++i) {
    Scene scene = MakeView(view, 2);
    test::Random random(1);
    conditions[i].apply(&scene, &random);
    const Image frame = RenderScene(scene);
    int changed = 0;
    for (int y = 0; y < frame.height(); ++y) {
      for (int x = 0; x < frame.width(); ++x) changed += frame.row(y)[x] != plain.row(y)[x];
    }
    EXPECT_GT(changed, 200) << conditions[i].name;
  }
}

TEST(BenchTest, PhotographsOfNoFolderAreAnError) {
  EXPECT_THROW(LoadPhotos("/nonexistent"), Error);
}

}  // namespace
}  // namespace topotag::bench
