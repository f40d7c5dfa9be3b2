#ifndef TOPOTAG_BENCH_ACCURACY_CELLS_H_
#define TOPOTAG_BENCH_ACCURACY_CELLS_H_

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/cramer_rao.h"
#include "bench/peers.h"
#include "bench/views.h"
#include "topotag/detector.h"

namespace topotag::bench {

/// Of one pose.
struct PoseError {
  double position = 0;  ///< metres
  double rotation = 0;  ///< radians
  /// Squared length of the error in standard deviations of the reported covariance: 6 in the
  /// mean where that is right. 0 without a covariance.
  double mahalanobis2 = 0;
};

/// One way to a pose, on the frames of a cell; nothing where it found no marker.
struct PoseErrors {
  std::string name;
  bool ours = false;
  std::vector<std::optional<PoseError>> frames;
};

/// All frames of one distance and tilt.
struct AccuracyCell {
  View view;
  std::vector<PoseBound> bounds;  ///< of our markers, one a frame
  std::vector<PoseErrors> systems;
};

/// Ours and the peers, each with its own marker in the same poses.
class AccuracyBench {
 public:
  /// @param aruco  OpenCV's, too.
  /// @param options  of ours, but for what the frames and the ways to a pose prescribe.
  explicit AccuracyBench(bool aruco, const Options& options = {});
  /// With the bounds.
  AccuracyCell Measure(const View& view, int frames, uint64_t seed);
  /// A cell without frames.
  AccuracyCell Empty(const View& view) const { return {view, {}, empty_}; }
  /// Adds a frame of one marker to a cell, without its bound.
  void MeasureFrame(const Scene& scene, AccuracyCell* cell);

 private:
  void MeasureOurs(const Scene& scene, AccuracyCell* cell);
  void MeasurePeer(const Scene& scene, Peer* peer, size_t* system, AccuracyCell* cell);

  Options options_;
  std::vector<PoseErrors> empty_;  ///< names of the systems, in the order of their results
  std::vector<std::unique_ptr<Peer>> peers_;
};

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_ACCURACY_CELLS_H_
