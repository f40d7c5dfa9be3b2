#ifndef TOPOTAG_HOST_TRACK_LIST_H_
#define TOPOTAG_HOST_TRACK_LIST_H_

#include <array>
#include <cstdint>
#include <vector>

#include "topotag/detection.h"
#include "topotag/tracker.h"

namespace topotag {

/// A place of a marker in the image, or by how much it moves from one frame to the next.
struct MarkerPlace {
  Point2 center;
  std::array<Point2, 4> corners;  ///< as Detection::corners
};

/// A marker that is followed.
struct Track {
  uint64_t number = 0;
  Family family{Family::kMinN};
  uint64_t id = 0;
  uint64_t unknown_bits = 0;  ///< that were hidden in every frame so far
  bool inverted = false;
  MarkerPlace place;      ///< when it was found last, pixels
  bool has_step = false;  ///< found in the last two frames
  MarkerPlace step{};     ///< from one to the other; 0 without
  double turn = 0;        ///< by how much a corner's step differs from the one before, at most
  int age = 0;
  int missed = 0;      ///< frames since it was found last, the current one included
  int detection = -1;  ///< of the current frame, -1 = none
};

/// Where a marker is expected in the next frame, and how far from there it is looked for.
struct Expectation {
  double min_x, min_y, max_x, max_y;  ///< of the white square's corners, pixels
  double margin;                      ///< around them, pixels

  /// How far its centre may be off.
  double Reach() const;
};

/// Every corner goes on as from the last frame but one to the last one, which holds for turns,
/// tilts and changes of distance as well; the margin covers what its motion has changed lately, and
/// some more. Where the step is not known, it is as large as the marker.
Expectation Expect(const Track& track);

/// The markers that are followed, and which detection is which of them.
class TrackList {
 public:
  const std::vector<Track>& tracks() const { return tracks_; }
  /// Tracks whose marker was not found in the last frame.
  int lost() const;
  void Clear();

  /// Gives each track the detection of its family and ID that is nearest to where it is expected,
  /// each to one track, the nearest pair first: markers of the same ID are told by their places.
  /// @param near_only  detections that are out of an expectation's reach do not count
  /// The tracks stay as they are until Advance.
  /// @return whether every track has one
  bool Match(const std::vector<Detection>& detections, bool near_only);

  /// Makes room for so many detections: after it and Clear, Match does not fail, nor does Advance
  /// where `states` has room for them, too.
  void Reserve(size_t detections);

  /// Goes on to the next frame with what Match found; other detections begin tracks, and tracks
  /// that have been lost for more than `max_missed` frames end. A failure leaves all as it was.
  /// @param states  of each detection; in_region as given
  void Advance(const std::vector<Detection>& detections, bool in_region, int max_missed,
               std::vector<TrackState>* states);

 private:
  struct Pair {
    double distance2;
    size_t track;
    size_t detection;
  };

  std::vector<Track> tracks_;  ///< in the order of their numbers
  std::vector<Pair> pairs_;
  std::vector<int> track_of_;  ///< of each detection, -1 = none
  uint64_t last_number_ = 0;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_TRACK_LIST_H_
