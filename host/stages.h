#ifndef TOPOTAG_HOST_STAGES_H_
#define TOPOTAG_HOST_STAGES_H_

#include <cstdint>
#include <vector>

#include "topotag/detector.h"
#include "topotag/image.h"

namespace topotag {

/// What the stages of a detector's last frame left behind, for pictures and for tests. Of the
/// region of interest where there is one. Needs a frame to have been detected.
class DetectorStages {
 public:
  explicit DetectorStages(const Detector& detector);

  /// Threshold of each pixel, grey levels.
  Image ThresholdMap() const;
  /// 255 = white, 0 = black.
  Image Binary() const;
  /// Component of each pixel, row-major, width * height; 0 = outside.
  std::vector<uint32_t> Labels() const;
  /// Bounding boxes of the candidates' white areas.
  std::vector<Rect> Candidates() const;
  /// Bounding boxes of the doubtful white areas: those that a second look goes to, as far as its
  /// budget reaches.
  std::vector<Rect> Doubts() const;

 private:
  const Detector::Impl& impl_;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_STAGES_H_
