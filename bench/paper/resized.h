#ifndef TOPOTAG_BENCH_PAPER_RESIZED_H_
#define TOPOTAG_BENCH_PAPER_RESIZED_H_

#include "topotag/renderer.h"

namespace topotag::bench::paper {

/// A scene of one marker with another design in its place, in the same pose; occluders that move
/// with the marker keep their size and place in metres.
/// @param tag_size  of the design: side of its white area, metres.
Scene WithDesign(const Scene& scene, const MarkerDesign& design, double tag_size);

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_RESIZED_H_
