#ifndef TOPOTAG_TRACKER_H_
#define TOPOTAG_TRACKER_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "topotag/detection.h"
#include "topotag/detector.h"
#include "topotag/error.h"
#include "topotag/geometry.h"
#include "topotag/image.h"
#include "topotag/options.h"

namespace topotag {

struct TrackerOptions {
  /// Everything that a detector is told. Frames that are searched wholly are shared by its threads;
  /// so are the regions of one frame, each of which a single thread searches. With the opencl
  /// backend, regions are searched by simd: the way to a device and back takes longer than they do.
  Options detection;
  /// At least every so many frames one is searched wholly, for markers that are new: 1 .. 1e6.
  /// Where no marker is known, every frame is.
  int search_interval = 30;
  /// For so many frames after a marker was lost every frame is searched wholly, so that the marker
  /// is found in the first one in which it can be read again. Then it is forgotten. 0 .. 1e6.
  int lost_frames = 90;
};

/// What tracking knows of one detection.
struct TrackState {
  /// The same as long as the marker is followed: 1, 2, ... in the order in which markers were found
  /// since the beginning, the last reset() or the last change of the frame's size.
  uint64_t number = 0;
  int age = 1;             ///< frames in which it was found, this one included
  int missed = 0;          ///< frames right before this one in which it was lost
  bool in_region = false;  ///< found where it was expected; else in a search of the whole frame
};

/// Finds TopoTags in the frames of a video, each marker first where the last frames say that it is
/// now: the rest of a frame is then not even read. A region is searched by the same stages as a
/// whole frame, with the same tiles and blocks; so a marker that lies in it has the same ID and, in
/// general to the last bit, the same vertices. Where a marker is not in its region, the whole frame
/// is searched in the same call. A marker that comes into view while others are followed may wait
/// for the next whole frame: TrackerOptions::search_interval.
/// Thread safety: one Tracker per thread, as one Detector.
class Tracker {
 public:
  /// @throws Error as Detector; kInvalidArgument: a value of `options` out of range.
  explicit Tracker(TrackerOptions options = {});
  ~Tracker();
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  /// Detects the markers in the next frame. A frame of another size than the last one begins anew,
  /// as reset().
  /// @return as Detector::detect
  /// @throws Error as Detector::detect; the tracks stay as they were.
  std::vector<Detection> track(const ImageView& image);
  /// The same into the caller's vector, whose capacity is reused; empty after an error.
  void track(const ImageView& image, std::vector<Detection>* detections);

  /// Of the detections of the last frame, in their order.
  const std::vector<TrackState>& states() const;
  /// Parts of the last frame that were searched because markers were expected there, apart from
  /// each other; empty where the whole frame was searched at once.
  const std::vector<Rect>& regions() const;
  /// Whether all of the last frame, or of its region of interest, was searched.
  bool searched_whole() const;
  /// Markers that are lost and still looked for.
  int lost() const;

  /// Forgets all markers.
  void reset();

  const TrackerOptions& options() const;
  /// What searched the last frame, as Detector::backend: where it was searched wholly, what did
  /// that.
  const std::string& backend() const;
  /// Of the last frame. Stages: sums over its regions; total: from beginning to end.
  const StageTimes& times() const;

 private:
  struct Impl;
  Impl& impl() const;
  std::unique_ptr<Impl> impl_;
};

}  // namespace topotag

#endif  // TOPOTAG_TRACKER_H_
