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

/// A shadow's edge in any direction, within a third of the side of marker 0 of its centre.
/// @param factor  share of the light that is left; @param penumbra  pixels.
void AddShadow(double factor, double penumbra, Scene* scene, test::Random* random);

/// Marker 0 moves across the image by `pixels` in `seconds`, in any direction.
void Move(double pixels, double seconds, Scene* scene, test::Random* random);

/// A spot of light of 12 pixels sigma, up to 30 pixels from the centre of marker 0 along either
/// axis. @param level  grey levels at its centre.
void AddHighlight(double level, Scene* scene, test::Random* random);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_HARD_CONDITIONS_H_
