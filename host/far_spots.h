#ifndef TOPOTAG_HOST_FAR_SPOTS_H_
#define TOPOTAG_HOST_FAR_SPOTS_H_

#include <cstdint>

#include "topotag/image.h"

namespace topotag {

/// Pixels along the image's border that are no spots.
inline constexpr int kSpotBorder = 8;

/// Dark spots of row y: pixels darker by `depth` grey levels or more than the brighter one of the
/// pixels `step` and 2 `step` away, in each of the four directions along the axes. With a step of
/// 1, the nodes of a marker with pitches of 2.6 to 8 pixels leave some, whatever its rotation.
/// @param x0, x1  columns; x0 is a multiple of 8, x1 too unless it is the width
/// @param bits    bit x % 8 of byte x / 8, from column 0 on; bytes x0 / 8 to (x1 + 7) / 8 are
/// written Highway kernel, dispatched at run time.
void FindSpots(const ImageView& image, int y, int x0, int x1, int step, int depth, uint8_t* bits);

/// Rounded means of 2 x 2 pixels: row y of the image at half the resolution, `count` from column
/// x0. Highway kernel, dispatched at run time.
void HalveRow(const ImageView& image, int y, int x0, int count, uint8_t* out);

}  // namespace topotag

#endif  // TOPOTAG_HOST_FAR_SPOTS_H_
