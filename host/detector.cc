#include "topotag/detector.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "host/bits.h"
#include "host/check.h"
#include "host/detector_impl.h"
#include "host/local_map.h"
#include "host/pose.h"
#include "host/vertices.h"

namespace topotag {
namespace {

// A doubtful white area is looked at again, a small one in twice the resolution, with thresholds
// as before, nearer to its white (holes that ran into a gap close), and nearer to its black (holes
// that vanished open). Where nothing like a marker is left, other thresholds bring none.
constexpr int kSecondLookSixteenths[] = {7, 8, 6};
constexpr int64_t kMaxUpsampledArea = 160 * 160;  // pixels
constexpr int kSecondLookMargin = 8;              // pixels around the white area
// All second looks of a frame together cover at most a quarter of it, or so many small areas: this
// bounds their time.
constexpr int64_t kSecondLookShare = 4;
constexpr int64_t kMinSecondLook = 4 * kMaxUpsampledArea;
// What decoding and refining read around a candidate: its surroundings within this margin, in
// pixels and in parts of its larger side. The white area has at least 13 units; nodes, their gaps
// and the frame, however the perspective moves them, stay within 3 units of it.
constexpr int kFetchMargin = 16;
constexpr int kFetchShare = 4;
constexpr double kMaxTagSize = 1e6;  // metres: keeps the covariance finite

std::string Size(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

void ValidateTagSize(double size, const std::string& what) {
  RequireRange(what, size, 0, kMaxTagSize, "metres");
}

Options Validated(Options options) {
  if (options.families.empty()) FailArgument("no family to detect");
  std::sort(options.families.begin(), options.families.end());
  const auto twin = std::adjacent_find(options.families.begin(), options.families.end());
  if (twin != options.families.end()) FailArgument("family " + twin->name() + " is named twice");
  if (options.threads < 1 || options.threads > kMaxThreads) {
    FailArgument("threads " + std::to_string(options.threads) + " is not in the range 1.." +
                 std::to_string(kMaxThreads));
  }
  if (options.camera) ValidateCamera(*options.camera);
  ValidateTagSize(options.tag_size, "tag size");
  for (const auto& [n, size] : options.family_tag_size) {
    const std::string name = Size(n, n);
    if (n < Family::kMinN || n > Family::kMaxN) {
      FailArgument("tag size of an unknown family " + name);
    }
    ValidateTagSize(size, "tag size of family " + name);
  }
  for (const auto& [key, size] : options.id_tag_size) {
    const auto& [n, id] = key;
    const std::string name = Size(n, n) + " ID " + std::to_string(id);
    if (n < Family::kMinN || n > Family::kMaxN || id >= Family(n).size()) {
      FailArgument("tag size of " + name + ", which does not exist");
    }
    ValidateTagSize(size, "tag size of " + name);
  }
  if (options.roi && (options.roi->x < 0 || options.roi->y < 0 || options.roi->width < 1 ||
                      options.roi->height < 1)) {
    FailArgument("region of interest is empty or begins outside the frame");
  }
  return options;
}

TreeParams MakeTreeParams(const Options& options) {
  TreeParams params;
  params.families = options.families;
  if (options.preset == Preset::kPaper) {
    params.tau = 0;
    params.baseline_reference = true;
  }
  return params;
}

ImageView Crop(const ImageView& image, const Rect& area) {
  return {image.row(area.y) + area.x, area.width, area.height, image.stride};
}

// A box grown by the margin of what is read around it, within the frame.
Rect WithMargin(const Rect& box, const ImageView& frame) {
  const int margin = kFetchMargin + std::max(box.width, box.height) / kFetchShare;
  const int x0 = std::max(box.x - margin, 0);
  const int y0 = std::max(box.y - margin, 0);
  return {x0, y0, std::min(box.x + box.width + margin, frame.width) - x0,
          std::min(box.y + box.height + margin, frame.height) - y0};
}

// A reading of a place that one of `count` markers was read at: the centres are less than half a
// pitch apart.
bool IsKnown(const Marker* markers, size_t count, const Decoded& decoded) {
  const LocalMap local(decoded.map, {0, 0});
  return std::any_of(markers, markers + count, [&](const Marker& other) {
    const double dx = other.center.x - local.center.x;
    const double dy = other.center.y - local.center.y;
    return dx * dx + dy * dy < 4 * std::abs(local.Determinant());
  });
}

static_assert(Detector::kMaxSubmitted == Backend::kMaxSubmitted);

bool ComesBefore(const Marker* a, const Marker* b) {
  const auto key = [](const Marker* m) {
    return std::make_tuple(m->decoded.family.n(), m->decoded.id, m->center.y, m->center.x);
  };
  return key(a) < key(b);
}

}  // namespace

Detector::Impl::Impl(Options o)
    : options(Validated(std::move(o))),
      workers(options.threads),
      backend(MakeBackend(options.backend, &workers, options.device)),
      second_backend(MakeSecondBackend(options.backend, &workers)),
      backend_name(backend->name()),
      first(MakeTreeParams(options)),
      second(MakeTreeParams(options)) {
  threshold_params.preset = options.preset;
}

Rect Detector::Impl::Area(const ImageView& image) const {
  ValidateImage(image);
  if (options.camera && options.camera->width != 0 &&
      (options.camera->width != image.width || options.camera->height != image.height)) {
    FailArgument("the camera is calibrated for " +
                 Size(options.camera->width, options.camera->height) + " pixels, the image has " +
                 Size(image.width, image.height));
  }
  const Rect area = options.roi.value_or(Rect{0, 0, image.width, image.height});
  if (area.width > image.width - area.x || area.height > image.height - area.y) {
    FailArgument("region of interest reaches outside the image of " +
                 Size(image.width, image.height) + " pixels");
  }
  return area;
}

double Detector::Impl::TagSize(Family family, uint64_t id) const {
  const auto by_id = options.id_tag_size.find({family.n(), id});
  if (by_id != options.id_tag_size.end()) return by_id->second;
  const auto by_family = options.family_tag_size.find(family.n());
  return by_family != options.family_tag_size.end() ? by_family->second : options.tag_size;
}

void Detector::Impl::Search(const ImageView& image, const Rect& whole) {
  marker_count = 0;
  first.Run(source == nullptr ? backend.get() : source->backend(), Crop(image, whole),
            threshold_params, &times);
  if (source != nullptr) FetchCandidates(whole);
  DecodeCandidates(image, first, {whole.x, whole.y, 1, whole});
  if (options.preset == Preset::kPaper) return;
  int64_t budget = std::max(int64_t{whole.width} * whole.height / kSecondLookShare, kMinSecondLook);
  for (const Doubt& doubt : first.tree.doubts()) {
    const Feature& white = doubt.white;
    const int x0 = std::max(white.min_x - kSecondLookMargin, 0);
    const int y0 = std::max(white.min_y - kSecondLookMargin, 0);
    const int x1 = std::min(white.max_x + kSecondLookMargin, whole.width - 1);
    const int y1 = std::min(white.max_y + kSecondLookMargin, whole.height - 1);
    const Rect part{whole.x + x0, whole.y + y0, x1 - x0 + 1, y1 - y0 + 1};
    const int64_t cost = int64_t{part.width} * part.height;
    if (cost > budget) continue;
    budget -= cost;
    LookAgain(image, whole, part);
  }
}

void Detector::Impl::FetchCandidates(const Rect& whole) {
  StopWatch watch;
  parts.clear();
  for (const Candidate& candidate : first.tree.candidates()) {
    const Feature& white = candidate.white;
    const Rect box{whole.x + white.min_x, whole.y + white.min_y, white.max_x - white.min_x + 1,
                   white.max_y - white.min_y + 1};
    parts.push_back(WithMargin(box, source->shadow()));
  }
  source->Fetch(parts);
  times.decode += watch.Lap();
}

void Detector::Impl::LookAgain(const ImageView& image, const Rect& whole, const Rect& part) {
  StopWatch watch;
  if (source != nullptr) {
    parts.assign(1, WithMargin(part, image));
    source->Fetch(parts);
  }
  const bool small = int64_t{part.width} * part.height <= kMaxUpsampledArea;
  const ImageView view = small ? Upsample(Crop(image, part), &upsampled) : Crop(image, part);
  times.threshold += watch.Lap();
  ThresholdParams params = threshold_params;
  const size_t before = marker_count;
  for (const int sixteenths : kSecondLookSixteenths) {
    if (!small && sixteenths == threshold_params.contrast_sixteenths) continue;
    params.contrast_sixteenths = sixteenths;
    second.Run(second_backend.get(), view, params, &times);
    DecodeCandidates(image, second, {part.x, part.y, small ? 2 : 1, whole});
    const bool is_doubtful = !second.tree.candidates().empty() || !second.tree.doubts().empty();
    if (marker_count > before || !is_doubtful) return;
  }
}

void Detector::Impl::DecodeCandidates(const ImageView& image, const Segmentation& segmentation,
                                      const SearchArea& area) {
  StopWatch watch;
  const std::vector<Candidate>& candidates = segmentation.tree.candidates();
  const size_t end = marker_count + candidates.size();
  if (markers.size() < end) markers.resize(end);
  workers.For(static_cast<int>(candidates.size()), [&](int i) {
    const Candidate& candidate = candidates[static_cast<size_t>(i)];
    Marker& marker = markers[marker_count + static_cast<size_t>(i)];
    marker.is_read =
        Decode(candidate, segmentation.tree.nodes(candidate), camera(), area, &marker.decoded) &&
        ConfirmBits(image, &marker.decoded);
  });
  for (size_t i = marker_count; i < end; ++i) {
    Marker& marker = markers[i];
    if (!marker.is_read || IsKnown(markers.data(), marker_count, marker.decoded)) continue;
    marker.center = marker.decoded.map.Pixel({0, 0});
    if (i != marker_count) markers[marker_count] = marker;
    ++marker_count;
  }
  times.decode += watch.Lap();
}

void Detector::Impl::MeasureVertices(const ImageView& image) {
  workers.For(static_cast<int>(marker_count), [&](int i) {
    Marker& marker = markers[static_cast<size_t>(i)];
    RefineVertices(image, &marker.decoded, &marker.vertices);
    marker.center = marker.decoded.map.Pixel({0, 0});
  });
}

void Detector::Impl::Report(std::vector<Detection>* detections) {
  order.clear();
  for (size_t i = 0; i < marker_count; ++i) order.push_back(&markers[i]);
  std::sort(order.begin(), order.end(), ComesBefore);
  detections->resize(order.size());
  for (size_t i = 0; i < order.size(); ++i) {
    const Decoded& decoded = order[i]->decoded;
    const double half = decoded.family.white_side() / 2.0;
    Detection& detection = (*detections)[i];
    detection.family = decoded.family;
    detection.id = decoded.id;
    detection.center = order[i]->center;
    detection.corners = {decoded.map.Pixel({-half, -half}), decoded.map.Pixel({half, -half}),
                         decoded.map.Pixel({half, half}), decoded.map.Pixel({-half, half})};
    detection.vertices = order[i]->vertices;
  }
}

void Detector::Impl::EstimatePoses(std::vector<Detection>* detections) {
  workers.For(static_cast<int>(order.size()), [&](int i) {
    Detection& detection = (*detections)[static_cast<size_t>(i)];
    detection.pose.reset();
    const double size = TagSize(detection.family, detection.id);
    if (camera() == nullptr || size == 0) return;
    const Homography& map = order[static_cast<size_t>(i)]->decoded.map.ideal;
    if (!EstimatePose(detection.family, detection.vertices, map, *camera(), size,
                      &detection.pose.emplace())) {
      detection.pose.reset();
    }
  });
}

Detector::Detector(Options options) : impl_(std::make_unique<Impl>(std::move(options))) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

std::vector<Detection> Detector::detect(const ImageView& image) {
  std::vector<Detection> detections;
  detect(image, &detections);
  return detections;
}

void Detector::Impl::Detect(FrameSource* from, const ImageView& image, const Rect& area,
                            std::vector<Detection>* detections) {
  if (source != from) {
    backend_name = from == nullptr ? backend->name() : from->backend()->name();
    source = from;
  }
  times = {};
  StopWatch total;
  Search(image, area);
  StopWatch watch;
  MeasureVertices(image);
  Report(detections);
  times.vertices = watch.Lap();
  EstimatePoses(detections);
  times.pose = watch.Lap();
  times.total = total.Lap();
}

void Detector::detect(const ImageView& image, std::vector<Detection>* detections) {
  detections->clear();
  if (!impl_->pending.empty()) FailArgument("detect: submitted frames have not been collected");
  impl_->Detect(nullptr, image, impl_->Area(image), detections);
}

void Detector::submit(const ImageView& image) {
  Impl& impl = *impl_;
  if (impl.pending.size() == static_cast<size_t>(kMaxSubmitted)) {
    FailArgument("submit: " + std::to_string(kMaxSubmitted) + " frames have not been collected");
  }
  const Rect area = impl.Area(image);
  impl.pending.reserve(kMaxSubmitted);
  impl.backend->Submit(Crop(image, area), impl.threshold_params);
  impl.pending.push_back({image, area});
}

bool Detector::collect(std::vector<Detection>* detections) {
  detections->clear();
  if (impl_->pending.empty()) return false;
  const Pending frame = impl_->pending.front();
  impl_->pending.erase(impl_->pending.begin());
  impl_->Detect(nullptr, frame.image, frame.area, detections);
  return true;
}

const Options& Detector::options() const { return impl_->options; }
const std::string& Detector::backend() const { return impl_->backend_name; }
const StageTimes& Detector::times() const { return impl_->times; }

const char* Version() { return TOPOTAG_VERSION; }

}  // namespace topotag
