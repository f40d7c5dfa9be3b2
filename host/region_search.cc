#include "host/region_search.h"

#include <algorithm>

#include "host/detector_impl.h"
#include "host/report_order.h"
#include "host/search_plan.h"
#include "host/stage_times.h"

namespace topotag {
namespace {

// More threads than that have nothing to do for the markers of one frame.
constexpr int kMaxEngines = 16;

// A backend that works in host memory, the detector's own one if that does.
Options EngineOptions(const Options& options, const std::string& backend) {
  Options result = options;
  result.backend =
      backend == Name(BackendKind::kScalar) ? BackendKind::kScalar : BackendKind::kSimd;
  result.device.reset();
  result.threads = 1;
  result.roi.reset();
  return result;
}

bool ComesBefore(const Detection* a, const Detection* b) {
  const auto key = [](const Detection* d) {
    return ReportKey(d->family, d->id, d->center, d->inverted);
  };
  return key(a) < key(b);
}

}  // namespace

struct RegionSearch::Engine {
  explicit Engine(const Options& options) : detector(options) {}

  Detector::Impl detector;
  std::vector<Detection> in_region;
  std::vector<Detection> found;  ///< the first `count` ones, in this frame's regions
  size_t count = 0;
  StageTimes times;
};

RegionSearch::RegionSearch(Detector* detector) : detector_(*detector) {
  const Options options = EngineOptions(detector_.options(), detector_.backend());
  const int count = std::min(detector_.options().threads, kMaxEngines);
  for (int i = 0; i < count; ++i) engines_.push_back(std::make_unique<Engine>(options));
}

RegionSearch::~RegionSearch() = default;

Rect RegionSearch::Area(const ImageView& image) const { return detector_.impl_->Area(image); }

const std::string& RegionSearch::backend() const { return engines_[0]->detector.backend_name; }

void RegionSearch::Search(const ImageView& image, const Rect& region, Engine* engine) {
  Detector::Impl& whole = *detector_.impl_;
  // Where frames are smoothed, what counts as contrast is a matter of the whole frame.
  engine->detector.threshold_params = whole.threshold_params;
  engine->detector.Detect(image, region, &engine->in_region);
  AddTimes(engine->detector.times, &engine->times);
  const Rect area = whole.Area(image);
  for (const Detection& detection : engine->in_region) {
    if (!IsInside(detection, region, area)) continue;
    if (engine->count == engine->found.size()) engine->found.emplace_back();
    engine->found[engine->count++] = detection;
  }
}

void RegionSearch::Run(const ImageView& image, const std::vector<Rect>& regions,
                       std::vector<Detection>* detections) {
  const ImageView prepared = detector_.impl_->Prepared(image);
  for (const auto& engine : engines_) {
    engine->count = 0;
    engine->times = {};
  }
  // Dealt in a fixed way: so each engine's workspace grows as the frames say, not as chance.
  const size_t threads = std::min(engines_.size(), regions.size());
  detector_.impl_->workers.For(static_cast<int>(threads), [&](int task) {
    const auto first = static_cast<size_t>(task);
    for (size_t i = first; i < regions.size(); i += threads) {
      Search(prepared, regions[i], engines_[first].get());
    }
  });
  times_ = {};
  order_.clear();
  for (const auto& engine : engines_) {
    AddTimes(engine->times, &times_);
    for (size_t i = 0; i < engine->count; ++i) order_.push_back(&engine->found[i]);
  }
  std::sort(order_.begin(), order_.end(), ComesBefore);
  detections->clear();
  for (const Detection* detection : order_) detections->push_back(*detection);
}

}  // namespace topotag
