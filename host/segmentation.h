#ifndef TOPOTAG_HOST_SEGMENTATION_H_
#define TOPOTAG_HOST_SEGMENTATION_H_

#include "host/backend.h"
#include "host/pipeline.h"
#include "host/stop_watch.h"
#include "host/tree.h"
#include "topotag/detector.h"

namespace topotag {

/// The stages from an image to the candidates in it, with their workspace.
struct Segmentation {
  explicit Segmentation(const TreeParams& params) : tree(params) {}

  /// Adds the stages' times to *times.
  void Run(Backend* backend, const ImageView& image, const ThresholdParams& params,
           StageTimes* times) {
    backend->Binarize(image, params, &bits, times);
    StopWatch watch;
    backend->Label(bits, &components);
    times->label += watch.Lap();
    tree.Find(components, backend);
    times->tree += watch.Lap();
  }

  BitImage bits;
  Components components;
  TopologyTree tree;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_SEGMENTATION_H_
