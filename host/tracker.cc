#include "topotag/tracker.h"

#include <utility>

#include "host/check.h"
#include "host/one_thread.h"
#include "host/region_search.h"
#include "host/search_plan.h"
#include "host/stage_times.h"
#include "host/stop_watch.h"
#include "host/track_list.h"

namespace topotag {
namespace {

constexpr int kMaxFrames = 1000000;

TrackerOptions Validated(TrackerOptions options) {
  RequireRange("search interval", options.search_interval, 1, kMaxFrames, "frames");
  RequireRange("lost frames", options.lost_frames, 0, kMaxFrames, "frames");
  return options;
}

}  // namespace

struct Tracker::Impl {
  explicit Impl(TrackerOptions o)
      : options(Validated(std::move(o))), detector(options.detection), search(&detector) {}

  bool SearchRegions(const ImageView& image, const Rect& area, std::vector<Detection>* detections);
  void Track(const ImageView& image, std::vector<Detection>* detections);
  void TrackNext(const ImageView& image, std::vector<Detection>* detections);
  void Reset();

  OneThread one_thread;
  TrackerOptions options;
  Detector detector;
  RegionSearch search;
  TrackList list;
  int width = 0;  ///< of the last frame
  int height = 0;
  int since_whole = 0;  ///< frames since one was searched wholly
  bool searched_whole = true;
  StageTimes times;
  std::vector<Rect> regions;
  std::vector<TrackState> states;
};

// False where all of the frame has to be searched.
bool Tracker::Impl::SearchRegions(const ImageView& image, const Rect& area,
                                  std::vector<Detection>* detections) {
  if (list.lost() != 0 || since_whole + 1 >= options.search_interval ||
      !PlanRegions(list.tracks(), area, &regions)) {
    return false;
  }
  search.Run(image, regions, detections);
  times = search.times();
  return list.Match(*detections, true);
}

void Tracker::Impl::Track(const ImageView& image, std::vector<Detection>* detections) {
  try {
    TrackNext(image, detections);
  } catch (...) {
    detections->clear();
    states.clear();
    regions.clear();
    throw;
  }
}

// What may fail comes before what changes the tracks.
void Tracker::Impl::TrackNext(const ImageView& image, std::vector<Detection>* detections) {
  StopWatch total;
  detections->clear();
  states.clear();
  regions.clear();
  times = {};
  const Rect area = search.Area(image);
  const bool begins_anew = image.width != width || image.height != height;
  const bool in_regions = !begins_anew && SearchRegions(image, area, detections);
  if (!in_regions) {
    detector.detect(image, detections);
    AddTimes(detector.times(), &times);
    if (begins_anew) {
      states.reserve(detections->size());
      list.Reserve(detections->size());
      Reset();
    }
    list.Match(*detections, false);
  }
  list.Advance(*detections, in_regions, options.lost_frames, &states);
  since_whole = in_regions ? since_whole + 1 : 0;
  searched_whole = !in_regions;
  width = image.width;
  height = image.height;
  times.total = total.Lap();
}

void Tracker::Impl::Reset() {
  list.Clear();
  since_whole = 0;
}

Tracker::Tracker(TrackerOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {}
Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;

Tracker::Impl& Tracker::impl() const {
  if (impl_ == nullptr) FailArgument("the tracker has been moved from");
  return *impl_;
}

std::vector<Detection> Tracker::track(const ImageView& image) {
  std::vector<Detection> detections;
  track(image, &detections);
  return detections;
}

void Tracker::track(const ImageView& image, std::vector<Detection>* detections) {
  RequireNotNull(detections, "detections");
  detections->clear();
  Impl& impl = this->impl();
  const OneThread::Use use(&impl.one_thread, "the tracker");
  impl.Track(image, detections);
}

const std::vector<TrackState>& Tracker::states() const { return impl().states; }
const std::vector<Rect>& Tracker::regions() const { return impl().regions; }
bool Tracker::searched_whole() const { return impl().searched_whole; }
int Tracker::lost() const { return impl().list.lost(); }
void Tracker::reset() { impl().Reset(); }
const TrackerOptions& Tracker::options() const { return impl().options; }
const std::string& Tracker::backend() const {
  return impl().searched_whole ? impl().detector.backend() : impl().search.backend();
}
const StageTimes& Tracker::times() const { return impl().times; }

}  // namespace topotag
