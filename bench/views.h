#ifndef TOPOTAG_BENCH_VIEWS_H_
#define TOPOTAG_BENCH_VIEWS_H_

#include <optional>

#include "topotag/renderer.h"

namespace topotag::bench {

/// How a single marker is seen.
struct View {
  Family family{4};
  double distance = 0.4;  ///< along the optical axis, metres
  double tilt = 0;        ///< of the marker's normal to the line of sight, degrees
  /// Without it, square nodes for even seeds and round ones for odd.
  std::optional<InnerShape> nodes{};
};

/// One marker of 5 cm, black frame included, in a frame of 1280 x 960 of a camera of 695 pixels
/// focal length; blur 0.7 pixels, noise 2, levels 25, 215 and 90. ID, turn about the line of
/// sight, direction of the tilt and place within the middle 40 % of the frame's width and height
/// are random.
Scene MakeView(const View& view, uint64_t seed);

/// Of every marker in a view, black frame included, metres.
inline constexpr double kViewSide = 0.05;

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_VIEWS_H_
