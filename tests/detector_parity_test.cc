// The whole detector on every backend, target and thread count: detections are the same, bit for
// bit, poses included.

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/detection_text.h"
#include "tests/frames.h"
#include "tests/scene_util.h"
#include "tests/simd_targets.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

using test::kDegree;

// Detectors of all backends with the same options. They stay from frame to frame.
class Detectors {
 public:
  explicit Detectors(Options options) {
    options.backend = BackendKind::kScalar;
    scalar_ = std::make_unique<Detector>(options);
    for (options.threads = 1; options.threads <= 4; ++options.threads) {
      options.backend = BackendKind::kSimd;
      for (const int64_t target : SimdTargets()) {
        const ForcedTarget forced(target);
        subjects_.push_back({std::make_unique<Detector>(options), target});
        EXPECT_EQ(subjects_.back().detector->backend(),
                  std::string("simd/") + hwy::TargetName(target));
      }
      options.backend = BackendKind::kOpenCl;
      try {
        subjects_.push_back({std::make_unique<Detector>(options), std::nullopt});
      } catch (const Error& error) {
        if (error.code() != ErrorCode::kUnavailable) throw;
      }
    }
  }

  /// Returns how many markers there are.
  size_t ExpectSame(const ImageView& image) {
    const std::vector<Detection> detections = scalar_->detect(image);
    const DetectionText expected(detections);
    for (Subject& subject : subjects_) {
      std::optional<ForcedTarget> forced;
      if (subject.target) forced.emplace(*subject.target);
      EXPECT_EQ(DetectionText(subject.detector->detect(image)).str(), expected.str())
          << subject.detector->backend() << ", " << subject.detector->options().threads
          << " threads";
    }
    return detections.size();
  }

 private:
  struct Subject {
    std::unique_ptr<Detector> detector;
    std::optional<int64_t> target;
  };
  std::unique_ptr<Detector> scalar_;
  std::vector<Subject> subjects_;
};

// Markers of several families side by side, down to the smallest that are found.
Scene RandomScene(test::Random* random) {
  Scene scene;
  scene.camera = test::PinholeCamera(640, 480, 600);
  scene.camera.model = DistortionModel::kBrown;
  scene.camera.distortion[0] = random->Uniform(-0.1, 0.05);
  scene.blur = random->Uniform(0.3, 1.2);
  scene.noise = random->Uniform(0, 6);
  scene.background = random->Uniform(40, 200);
  scene.seed = random->Below(1000);
  const int columns = 3, rows = 2;
  for (int i = 0; i < columns * rows; ++i) {
    SceneMarker marker;
    marker.design.family = Family(3 + static_cast<int>(random->Below(3)));
    marker.design.id = random->Below(marker.design.family.size());
    const double pitch = random->Uniform(6, 16);
    const double z =
        test::DistanceForPitch(scene.camera, marker.design.family, marker.tag_size, pitch);
    marker.R = random->Tilted(random->Uniform(0, 55) * kDegree);
    marker.t = {(i % columns - 1) * 200 * z / 600, (i / columns - 0.5) * 220 * z / 600, z};
    scene.markers.push_back(marker);
  }
  return scene;
}

Options WithPoses(const Scene& scene) {
  Options options;
  options.camera = scene.camera;
  options.tag_size = 0.05;
  return options;
}

TEST(DetectorParityTest, RenderedScenes) {
  test::Random random(17);
  size_t markers = 0;
  for (int i = 0; i < 24; ++i) {
    SCOPED_TRACE(i);
    const Scene scene = RandomScene(&random);
    Options options = WithPoses(scene);
    if (i % 4 == 3) options.preset = Preset::kPaper;
    if (i % 6 == 5) options.roi = Rect{101, 33, 455, 399};
    Detectors detectors(options);
    const Image image = RenderScene(scene);
    markers += detectors.ExpectSame(image.view());
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GE(markers, 60u);
}

// The same detectors for frames of all sizes and contents: nothing is left of the last one.
TEST(DetectorParityTest, SceneAfterAnyOtherFrame) {
  test::Random random(18);
  const Scene scene = RandomScene(&random);
  const Image image = RenderScene(scene);
  Options options;
  options.families = Family::ParseList("3x3,4x4,5x5,6x6,7x7,8x8");
  Detectors detectors(options);
  const size_t markers = detectors.ExpectSame(image.view());
  EXPECT_GE(markers, 1u);
  for (uint64_t seed = 0; seed < 130 && !testing::Test::HasFailure(); ++seed) {
    const FrameCase c = RandomFrameCase(seed);
    SCOPED_TRACE(testing::PrintToString(c));
    detectors.ExpectSame(MakeFrame(c).view());
    if (seed % 13 != 0) continue;
    EXPECT_EQ(detectors.ExpectSame(image.view()), markers);
  }
}

}  // namespace
}  // namespace topotag
