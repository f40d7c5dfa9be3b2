#ifndef TOPOTAG_BENCH_RANGE_RUNS_H_
#define TOPOTAG_BENCH_RANGE_RUNS_H_

#include <memory>
#include <string>
#include <vector>

#include "bench/peers.h"
#include "bench/views.h"
#include "topotag/detector.h"

namespace topotag::bench {

/// A system on all frames of one distance.
struct Recall {
  int frames = 0;
  int found = 0;
  int wrong = 0;  ///< detections of what is not there, or of a marker for the second time
};

/// Frames of one tilt and kind of background.
struct RangeRun {
  std::string background;
  double tilt = 0;                ///< degrees
  std::vector<double> distances;  ///< metres
  std::vector<std::string> systems;
  std::vector<std::vector<Recall>> recall;  ///< [system][distance]
};

/// Reads single markers of each family and AprilTag 3's, all in the same poses. What it finds
/// that is not there goes to stderr, with the seed of MakeView.
class RangeBench {
 public:
  /// @param options  of ours; the families to look for are those of the markers.
  explicit RangeBench(const Options& options);
  /// @param backgrounds  in rotation; empty: a plain wall.
  RangeRun Measure(const std::string& background, const std::vector<Image>& backgrounds,
                   double tilt, const std::vector<double>& distances, int frames);

 private:
  void MeasureFrame(const View& view, uint64_t seed, const ImageView& background, size_t distance,
                    RangeRun* run);

  std::vector<Family> families_;
  Detector detector_;
  std::unique_ptr<Peer> peer_;
};

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_RANGE_RUNS_H_
