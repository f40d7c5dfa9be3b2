#ifndef TOPOTAG_DETECTOR_H_
#define TOPOTAG_DETECTOR_H_

#include <memory>
#include <string>
#include <vector>

#include "topotag/detection.h"
#include "topotag/error.h"
#include "topotag/image.h"
#include "topotag/options.h"

namespace topotag {

/// Time of each stage of one frame, microseconds.
struct StageTimes {
  double threshold = 0;
  double binarize = 0;
  double label = 0;
  double tree = 0;
  double decode = 0;
  double vertices = 0;
  double pose = 0;
  double total = 0;
};

/// Finds TopoTags in frames. Holds its configuration and its workspace; nothing is global.
/// Thread safety: one Detector per thread. Builds without NDEBUG notice where a second thread uses
/// one that is at work: its call throws Error (kInvalidArgument).
/// One that was moved from can be destroyed and assigned to; everything else throws Error
/// (kInvalidArgument).
class Detector {
 public:
  /// @throws Error (kInvalidArgument: a value of `options` out of range; kUnavailable: a backend
  ///         or threads that this build or machine does not have; kDevice); std::bad_alloc.
  explicit Detector(Options options = {});
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  /// Detects the markers in one grayscale frame.
  ///
  /// Paper: section 4 (detection), departures in docs/design.md.
  /// @param image  height x width, 8-bit luminance, not owned; stride in bytes, >= width; only
  /// read.
  /// @return detections sorted by (family, id, centre y, centre x); empty when there is none.
  /// @throws Error (kInvalidArgument: null data, stride < width, size out of range or other than
  ///         the camera's, region of interest outside the frame; kDevice).
  /// Bit-identical across backends and thread counts up to and including the vertices.
  std::vector<Detection> detect(const ImageView& image);
  /// The same into the caller's vector, whose capacity is reused; empty after an error. After one,
  /// the next frame is detected as if it had not been.
  void detect(const ImageView& image, std::vector<Detection>* detections);

  /// Begins with a frame, of which collect() gives the detections: with the opencl backend, the
  /// device then works on one frame while the processor finishes the one before. Up to
  /// kMaxSubmitted frames; each stays the caller's, in place and unchanged until it is collected.
  /// @throws Error as detect(); kInvalidArgument: too many frames
  void submit(const ImageView& image);
  static constexpr int kMaxSubmitted = 2;
  /// The detections of the oldest submitted frame.
  /// @return false where there is none
  /// @throws Error as detect(); then that frame is done with, and no detection is given
  bool collect(std::vector<Detection>* detections);

  /// The photometric step for one detection of this frame, whatever Options::pose. Needs a camera.
  /// Of an inverted marker the whole frame is inverted first: 1 ms for 8 megapixels.
  /// @param detection  as detect() gave it; the pose may be the caller's own prediction
  /// @return false where it is rejected, or there is no pose to start from: then it stays as it is
  /// @throws Error (kInvalidArgument) as detect(); also corners, vertices or a pose that are not
  ///         finite, an ID or unknown bits outside the family
  bool refine(const ImageView& image, Detection* detection);

  const Options& options() const;
  /// The backend that ran last, with its target or device: "scalar", "simd/AVX2", "opencl/DEVICE".
  const std::string& backend() const;
  /// Of the last frame.
  const StageTimes& times() const;

 private:
  friend class DetectorStages;
  friend class OpenClDetection;
  friend class RegionSearch;
  struct Impl;
  Impl& impl() const;

  std::unique_ptr<Impl> impl_;
};

/// "1.2.3"
const char* Version();

}  // namespace topotag

#endif  // TOPOTAG_DETECTOR_H_
