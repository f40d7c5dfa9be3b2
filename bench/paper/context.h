#ifndef TOPOTAG_BENCH_PAPER_CONTEXT_H_
#define TOPOTAG_BENCH_PAPER_CONTEXT_H_

#include <functional>
#include <string>

#include "bench/paper/progress.h"
#include "bench/paper/section.h"
#include "bench/photos.h"

namespace topotag::bench::paper {

/// What every section is given.
struct Context {
  bool quick = false;              ///< a few frames of everything
  int threads = 1;                 ///< that render and detect at a time, where time is not measured
  std::string photos_folder;       ///< "" = none
  const Photos* photos = nullptr;  ///< backgrounds: of the folder, else procedural clutter
  Progress* progress = nullptr;

  /// `full`, or `quick` frames.
  int Frames(int full, int few) const { return quick ? few : full; }
};

/// Calls work(index, worker) for each index 0 .. count - 1, in no particular order, on
/// context.threads threads; 0 <= worker < context.threads says which, so that each can have
/// detectors of its own. Results belong into slots of their index: they must not depend on the
/// order. Each call is a step of the progress; a section says how many it has in all by
/// context.progress->SetSteps(). An exception of a call ends the work and is thrown again here.
void ForEachFrame(const Context& context, int count,
                  const std::function<void(int index, int worker)>& work);

/// The sections, each in a file of its own.
Section MeasureRange(const Context& context);           // range.cc: dictionary, min/max distance
Section MeasureSequences(const Context& context);       // sequences.cc: recall, precision, errors
Section MeasureTime(const Context& context);            // time.cc
Section MeasureFalsePositives(const Context& context);  // false_positives.cc
Section MeasureJitter(const Context& context);          // jitter.cc: of poses and vertices
Section MeasureShapes(const Context& context);          // shapes.cc
Section MeasureOcclusion(const Context& context);       // occlusion.cc
Section MeasureNoise(const Context& context);           // noise.cc
Section MeasureLight(const Context& context);           // light.cc: light and motion

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_CONTEXT_H_
