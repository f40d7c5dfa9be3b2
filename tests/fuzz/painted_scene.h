#ifndef TOPOTAG_TESTS_FUZZ_PAINTED_SCENE_H_
#define TOPOTAG_TESTS_FUZZ_PAINTED_SCENE_H_

#include "tests/fuzz/input.h"
#include "tests/random_image.h"
#include "topotag/camera.h"

namespace topotag::fuzz {

/// Paints a scene that an input describes: a background, up to three markers in any position, an
/// occluder, a shadow edge, blur, noise, and single pixels of any level. Far from exact, but fast,
/// and like enough to markers that every stage of the detector has work.
/// @param camera  of the image's size; its lens is left out
void PaintScene(Input* input, const Camera& camera, PaddedImage* image);

}  // namespace topotag::fuzz

#endif  // TOPOTAG_TESTS_FUZZ_PAINTED_SCENE_H_
