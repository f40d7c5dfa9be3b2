#ifndef TOPOTAG_TESTS_SIMD_TARGETS_H_
#define TOPOTAG_TESTS_SIMD_TARGETS_H_

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cstdint>
#include <string>
#include <vector>

#include "simd/simd_backend.h"

namespace topotag {

/// The targets that simd/ is compiled for and this machine can run, the emulation included. Needs
/// the definitions that simd/ is compiled with.
inline std::vector<int64_t> SimdTargets() {
  std::vector<int64_t> targets;
  const int64_t all = (hwy::SupportedTargets() | HWY_EMU128) & HWY_TARGETS;
  for (int64_t rest = all; rest != 0; rest &= rest - 1) targets.push_back(rest & -rest);
  return targets;
}

/// While it lives, simd/ runs on this target; fails the test where it does not.
class ForcedTarget {
 public:
  explicit ForcedTarget(int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    EXPECT_EQ(simd::TargetName(), hwy::TargetName(target)) << "the forced target did not run";
  }
  ForcedTarget(const ForcedTarget&) = delete;
  ForcedTarget& operator=(const ForcedTarget&) = delete;
  ~ForcedTarget() { hwy::SetSupportedTargetsForTest(0); }
};

/// A test of one target.
class SimdTest : public ::testing::TestWithParam<int64_t> {
 protected:
  std::string target() const { return hwy::TargetName(GetParam()); }

 private:
  ForcedTarget forced_{GetParam()};
};

#define TOPOTAG_INSTANTIATE_SIMD_TEST(suite)              \
  INSTANTIATE_TEST_SUITE_P(                               \
      Targets, suite, ::testing::ValuesIn(SimdTargets()), \
      [](const auto& info) { return std::string(hwy::TargetName(info.param)); })

}  // namespace topotag

#endif  // TOPOTAG_TESTS_SIMD_TARGETS_H_
