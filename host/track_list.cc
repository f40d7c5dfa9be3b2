#include "host/track_list.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "host/pipeline.h"

namespace topotag {
namespace {

// The margin, in parts of the marker's side, of its step and of the last change of that. A wider
// one costs a region's time in each frame, a narrower one a whole search where a marker turns: with
// these, one turn by a right angle at a third of a side a frame stays within.
constexpr double kSideShare = 0.1;
constexpr double kStepShare = 0.25;
constexpr double kTurnShare = 0.5;

Point2 Sum(const Point2& a, const Point2& b) { return {a.x + b.x, a.y + b.y}; }
Point2 Difference(const Point2& a, const Point2& b) { return {a.x - b.x, a.y - b.y}; }

double Distance2(const Point2& a, const Point2& b) {
  const Point2 d = Difference(a, b);
  return d.x * d.x + d.y * d.y;
}

Point2 ExpectedCenter(const Track& track) { return Sum(track.place.center, track.step.center); }

// Bits that are hidden here or there agree with everything.
bool IsSameMarker(const Track& track, const Detection& detection) {
  const uint64_t differing = track.id ^ detection.id;
  return track.family == detection.family && track.inverted == detection.inverted &&
         (differing & ~(track.unknown_bits | detection.unknown_bits)) == 0;
}

void AddKnownBits(const Detection& detection, Track* track) {
  track->id |= detection.id;  // hidden bits are 0 in both
  track->unknown_bits &= detection.unknown_bits;
}

// Takes the place of a detection; the step is known where the marker was found one frame before.
void MoveTo(const Detection& detection, bool has_step, Track* track) {
  const MarkerPlace last = track->step;
  track->step = {};
  track->turn = 0;
  track->has_step = has_step;
  if (has_step) {
    track->step.center = Difference(detection.center, track->place.center);
    double turn2 = 0;
    for (size_t i = 0; i < 4; ++i) {
      track->step.corners[i] = Difference(detection.corners[i], track->place.corners[i]);
      turn2 = std::max(turn2, Distance2(track->step.corners[i], last.corners[i]));
    }
    track->turn = std::sqrt(turn2);
  }
  track->place = {detection.center, detection.corners};
}

}  // namespace

double Expectation::Reach() const { return margin + std::max(max_x - min_x, max_y - min_y) / 2; }

Expectation Expect(const Track& track) {
  Expectation e{INFINITY, INFINITY, -INFINITY, -INFINITY, 0};
  double step2 = 0;
  for (size_t i = 0; i < 4; ++i) {
    const Point2& step = track.step.corners[i];
    const Point2 corner = Sum(track.place.corners[i], step);
    e.min_x = std::min(e.min_x, corner.x), e.max_x = std::max(e.max_x, corner.x);
    e.min_y = std::min(e.min_y, corner.y), e.max_y = std::max(e.max_y, corner.y);
    step2 = std::max(step2, Distance2(step, {}));
  }
  const double side = std::max(e.max_x - e.min_x, e.max_y - e.min_y);
  // A tile on each side takes part in the thresholds of the marker's outermost tiles.
  e.margin = kTile + (track.has_step ? kSideShare * side + kStepShare * std::sqrt(step2) +
                                           kTurnShare * track.turn
                                     : side);
  return e;
}

int TrackList::lost() const {
  return static_cast<int>(std::count_if(tracks_.begin(), tracks_.end(),
                                        [](const Track& track) { return track.missed > 0; }));
}

void TrackList::Clear() {
  tracks_.clear();
  last_number_ = 0;
}

bool TrackList::Match(const std::vector<Detection>& detections, bool near_only) {
  pairs_.clear();
  for (size_t t = 0; t < tracks_.size(); ++t) {
    Track& track = tracks_[t];
    track.detection = -1;
    const double reach = near_only ? Expect(track).Reach() : INFINITY;
    for (size_t d = 0; d < detections.size(); ++d) {
      if (!IsSameMarker(track, detections[d])) continue;
      const double distance2 = Distance2(ExpectedCenter(track), detections[d].center);
      if (distance2 <= reach * reach) pairs_.push_back({distance2, t, d});
    }
  }
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.distance2, a.track, a.detection) <
           std::tie(b.distance2, b.track, b.detection);
  });
  track_of_.assign(detections.size(), -1);
  size_t matched = 0;
  for (const Pair& pair : pairs_) {
    if (tracks_[pair.track].detection != -1 || track_of_[pair.detection] != -1) continue;
    tracks_[pair.track].detection = static_cast<int>(pair.detection);
    track_of_[pair.detection] = static_cast<int>(pair.track);
    ++matched;
  }
  return matched == tracks_.size();
}

void TrackList::Reserve(size_t detections) {
  track_of_.reserve(detections);
  tracks_.reserve(detections);
}

void TrackList::Advance(const std::vector<Detection>& detections, bool in_region, int max_missed,
                        std::vector<TrackState>* states) {
  const auto found_first = std::count(track_of_.begin(), track_of_.end(), -1);
  tracks_.reserve(tracks_.size() + static_cast<size_t>(found_first));
  states->reserve(detections.size());
  for (size_t d = 0; d < detections.size(); ++d) {
    if (track_of_[d] != -1) continue;
    track_of_[d] = static_cast<int>(tracks_.size());
    Track track;
    track.number = ++last_number_;
    track.family = detections[d].family;
    track.unknown_bits = detections[d].unknown_bits;
    track.inverted = detections[d].inverted;
    track.detection = static_cast<int>(d);
    tracks_.push_back(track);
  }
  states->clear();
  for (size_t d = 0; d < detections.size(); ++d) {
    Track& track = tracks_[static_cast<size_t>(track_of_[d])];
    AddKnownBits(detections[d], &track);
    MoveTo(detections[d], track.age != 0 && track.missed == 0, &track);
    ++track.age;
    states->push_back({track.number, track.age, track.missed, in_region});
    track.missed = 0;
  }
  for (Track& track : tracks_) {
    if (track.detection != -1) continue;
    ++track.missed;
    track.step = {};
    track.turn = 0;
    track.has_step = false;
  }
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(),
                               [=](const Track& track) { return track.missed > max_missed; }),
                tracks_.end());
}

}  // namespace topotag
