#ifndef TOPOTAG_BENCH_HARD_CONDITIONS_H_
#define TOPOTAG_BENCH_HARD_CONDITIONS_H_

#include <functional>
#include <string>
#include <vector>

#include "tests/scene_util.h"
#include "topotag/renderer.h"

namespace topotag::bench {

/// What makes a scene of one marker hard.
struct HardCondition {
  std::string name;
  std::function<void(Scene*, test::Random*)> apply;
};

/// Light, motion, focus, noise, print and occlusion, plain frames first. Lengths in pixels are for
/// a marker of some 90 pixels.
std::vector<HardCondition> HardConditions();

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_HARD_CONDITIONS_H_
