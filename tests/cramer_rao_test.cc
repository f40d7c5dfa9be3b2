// The bound against closed forms.
#include "bench/cramer_rao.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bench/views.h"
#include "host/cholesky.h"
#include "tests/renderer_test_util.h"
#include "tests/scene_util.h"

namespace topotag::bench {
namespace {

TEST(CramerRaoTest, StepOfTheDifferencesDoesNotMatter) {
  for (const View view : {View{Family(4), 0.2, 0}, View{Family(4), 0.8, 75}}) {
    const Scene scene = MakeView(view, 2);
    const PoseBound bound = CramerRaoBound(scene), halved = CramerRaoBound(scene, 0.02);
    EXPECT_NEAR(halved.rms_position / bound.rms_position, 1, 0.003);
    EXPECT_NEAR(halved.rms_rotation / bound.rms_rotation, 1, 0.003);
  }
}

TEST(CramerRaoTest, ScalesWithTheNoise) {
  Scene scene = MakeView({Family(4), 0.4, 30}, 3);
  scene.noise = 2;
  const PoseBound quiet = CramerRaoBound(scene);
  scene.noise = 6;
  const double ratio = std::sqrt((36 + 1.0 / 12) / (4 + 1.0 / 12));
  EXPECT_NEAR(CramerRaoBound(scene).rms_position / quiet.rms_position, ratio, 1e-6);
}

TEST(CramerRaoTest, ShiftOfUprightMarkerEqualsClosedForm) {
  // Edges far apart in a blur much wider than a pixel: each unit of length of an upright edge
  // tells contrast^2 / (2 sqrt(pi) sigma variance) about a shift along x.
  constexpr double kPitch = 20, kSigma = 2;
  Scene scene = FrontalScene(480, 480, 240, 240, kPitch);
  scene.blur = kSigma;
  scene.noise = 2;
  SceneMarker& marker = scene.markers[0];
  marker.design.id = (1 << 14) - 1;         // 14 nodes with a hole each; the baseline node has two
  const double frame = 19 * 2 * 65.0 * 65;  // to the background
  const double shapes = (17 * 2 + 15 * 3 * 2 + 16 * 2) * 190.0 * 190;
  const double sigma = std::sqrt(kSigma * kSigma + 1.0 / 12);
  const double information =
      (frame + shapes) * kPitch / (2 * std::sqrt(M_PI) * sigma) / (4 + 1.0 / 12);
  const double metres_per_pixel = marker.t[2] / scene.camera.fx;
  const double expected = information / (metres_per_pixel * metres_per_pixel);
  // Of x alone, the rest of the pose known.
  Matrix6 covariance = CramerRaoBound(scene).covariance, inverse;
  ASSERT_TRUE(InvertPositive(covariance[0].data(), 6, inverse[0].data()));
  const double found = inverse[3][3];
  // The other unknowns, levels and blur, cost a little.
  EXPECT_LE(found, 1.01 * expected);
  EXPECT_GE(found, 0.95 * expected);
}

TEST(CramerRaoTest, MedianOfNorm) {
  EXPECT_NEAR(MedianNorm({{{4, 0, 0}, {0, 0, 0}, {0, 0, 0}}}), 2 * 0.6745, 0.04);
  EXPECT_NEAR(MedianNorm({{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}), 1.5382, 0.03);
  // Fully correlated: along the diagonal, of variance 3.
  EXPECT_NEAR(MedianNorm({{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}}), std::sqrt(3) * 0.6745, 0.04);
}

TEST(CholeskyTest, InvertsAndRejects) {
  const Matrix3 matrix{{{4e6, 200, 0}, {200, 2, 1e-4}, {0, 1e-4, 3e-8}}};
  Matrix3 factor = matrix, inverse;
  ASSERT_TRUE(InvertPositive(factor[0].data(), 3, inverse[0].data()));
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      const double sum = matrix[i][0] * inverse[0][j] + matrix[i][1] * inverse[1][j] +
                         matrix[i][2] * inverse[2][j];
      EXPECT_NEAR(sum, i == j, 1e-9);
    }
  }
  Matrix3 indefinite{{{1, 2, 0}, {2, 1, 0}, {0, 0, 1}}};
  EXPECT_FALSE(Factorize(indefinite[0].data(), 3));
}

}  // namespace
}  // namespace topotag::bench
