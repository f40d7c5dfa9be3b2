#include "topotag/detector.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "host/bits.h"
#include "host/check.h"
#include "host/detector_impl.h"
#include "host/far_pose.h"
#include "host/local_map.h"
#include "host/mean_side.h"
#include "host/model.h"
#include "host/options_check.h"
#include "host/partial.h"
#include "host/pose.h"
#include "host/report_order.h"
#include "host/vertices.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

// Of a white area's box, width and height together, in parts of the least size. Those of a whole
// marker are twice its mean side at least. Covered, shadowed or cut by the threshold, half of it
// may be missing: then they still are 1.5 of it, and 1.2 where it is seen at 75 degrees.
constexpr double kMinExtent = 1.2;

// Of the whole area, or of second looks at a part of it, which may be enlarged.
TreeParams MakeTreeParams(const Options& options, bool is_whole) {
  TreeParams params;
  if (is_whole) params.min_extent = static_cast<int>(kMinExtent * options.min_size);
  params.families = options.families;
  params.lost_baselines = options.preset == Preset::kDefault;
  if (options.preset == Preset::kPaper) {
    params.tau = 0;
    params.baseline_reference = true;
  }
  return params;
}

// Of a marker that was found in the complement: the levels that the frame shows.
void UndoComplement(Photometric* found) {
  found->black = 255 - found->black;
  found->white = 255 - found->white;
}

void ProjectVertices(const Decoded& decoded, VertexList* vertices) {
  vertices->resize(decoded.family.vertex_count());
  for (int i = 0; i < vertices->size(); ++i) {
    (*vertices)[i] = decoded.map.Pixel(ModelTable(decoded.family)[i]);
  }
}

// A detection with a pose, from the user's hands.
void ValidatePosed(const Detection& detection) {
  const Family family = detection.family;
  if (detection.vertices.size() != family.vertex_count()) {
    FailArgument("the detection has " + std::to_string(detection.vertices.size()) +
                 " vertices, family " + family.name() + " has " +
                 std::to_string(family.vertex_count()));
  }
  if (std::max(detection.id, detection.unknown_bits) >= family.size()) {
    FailArgument("the detection's ID or unknown bits are not in the range of family " +
                 family.name());
  }
  if (!IsFinite(*detection.pose) ||
      (detection.pose->alternative && !IsFinite(*detection.pose->alternative))) {
    FailArgument("the detection's pose is not finite");
  }
  const auto is_finite = [](const Point2& p) { return std::isfinite(p.x) && std::isfinite(p.y); };
  if (!std::all_of(detection.corners.begin(), detection.corners.end(), is_finite) ||
      !std::all_of(detection.vertices.begin(), detection.vertices.end(), is_finite)) {
    FailArgument("the detection's corners or vertices are not finite");
  }
}

static_assert(Detector::kMaxSubmitted == Backend::kMaxSubmitted);

bool ComesBefore(const Marker* a, const Marker* b) {
  const auto key = [](const Marker* m) {
    return ReportKey(m->decoded.family, m->decoded.id, m->center, m->is_inverted);
  };
  return key(a) < key(b);
}

}  // namespace

Detector::Impl::Impl(Options o)
    : options(ValidatedOptions(std::move(o))),
      workers(options.threads),
      backend(MakeBackend(options.backend, &workers, options.device)),
      second_backend(MakeSecondBackend(options.backend, &workers)),
      backend_name(backend->name()),
      first(MakeTreeParams(options, true)),
      second(MakeTreeParams(options, false)),
      ids(options.ids),
      photometric(static_cast<size_t>(options.threads)) {
  threshold_params.preset = options.preset;
  if (options.pose == PoseMode::kPhotometric) {
    for (PhotometricWorkspace& workspace : photometric) workspace.Reserve();
  }
  if (options.far && options.preset != Preset::kPaper) {
    far.emplace(options.families, kSurelySmaller * options.min_size);
  }
  if (options.inverted) {
    complement_search.emplace(options.backend, &workers, MakeTreeParams(options, true));
  }
}

Rect Detector::Impl::Area(const ImageView& image) const {
  ValidateImage(image);
  if (options.camera && options.camera->width != 0 &&
      (options.camera->width != image.width || options.camera->height != image.height)) {
    FailArgument("the camera is calibrated for " +
                 Text(options.camera->width, options.camera->height) + " pixels, the image has " +
                 Text(image.width, image.height));
  }
  const Rect area = options.roi.value_or(Rect{0, 0, image.width, image.height});
  if (area.width > image.width - area.x || area.height > image.height - area.y) {
    FailArgument("region of interest reaches outside the image of " +
                 Text(image.width, image.height) + " pixels");
  }
  return area;
}

ImageView Detector::Impl::Prepared(const ImageView& image) {
  if (!options.pre_blur) return image;
  const ImageView result = PreBlur(image, &smoothed[next_smoothed]);
  threshold_params.min_contrast = std::max(ThresholdParams().min_contrast, NoiseContrast(result));
  return result;
}

void Detector::Impl::MeasureVertices(const FrameViews& frame) {
  workers.For(static_cast<int>(marker_count), [&](int i) {
    Marker& marker = markers[static_cast<size_t>(i)];
    if (marker.is_far) {
      ProjectVertices(marker.decoded, &marker.vertices);
    } else {
      RefineVertices(frame.Of(marker.is_inverted), &marker.decoded, &marker.vertices);
    }
    marker.center = marker.decoded.map.Pixel({0, 0});
  });
}

void Detector::Impl::Report(std::vector<Detection>* detections) {
  order.clear();
  for (size_t i = 0; i < marker_count; ++i) {
    const Decoded& decoded = markers[i].decoded;
    if (options.min_size == 0 ||
        MeanSide(WhiteCorners(decoded.map, decoded.family).data()) >= options.min_size) {
      order.push_back(&markers[i]);
    }
  }
  std::sort(order.begin(), order.end(), ComesBefore);
  detections->resize(order.size());
  for (size_t i = 0; i < order.size(); ++i) {
    const Decoded& decoded = order[i]->decoded;
    Detection& detection = (*detections)[i];
    detection.family = decoded.family;
    detection.id = decoded.id;
    detection.unknown_bits = IdFromVertexBits(decoded.family, decoded.hidden);
    detection.inverted = order[i]->is_inverted;
    detection.center = order[i]->center;
    detection.corners = WhiteCorners(decoded.map, decoded.family);
    detection.vertices = order[i]->vertices;
    detection.margin.reset();
    if (order[i]->is_far) detection.margin = order[i]->far.margin;
    detection.quality = decoded.quality;
  }
}

void Detector::Impl::EstimatePoses(std::vector<Detection>* detections) {
  workers.For(static_cast<int>(order.size()), [&](int i) {
    Detection& detection = (*detections)[static_cast<size_t>(i)];
    detection.pose.reset();
    const double size = TagSize(options, detection.family, detection.id);
    if (camera() == nullptr || size == 0) return;
    const Decoded& decoded = order[static_cast<size_t>(i)]->decoded;
    if (!EstimatePose(detection.family, detection.vertices, decoded.map.ideal, *camera(), size,
                      &detection.pose.emplace(), decoded.unmeasured)) {
      detection.pose.reset();
    } else if (order[static_cast<size_t>(i)]->is_far) {
      SetFarCovariance(detection.family, order[static_cast<size_t>(i)]->far, *camera(), size,
                       &*detection.pose);
    }
  });
}

void Detector::Impl::RefinePoses(const FrameViews& frame, std::vector<Detection>* detections) {
  if (camera() == nullptr) return;
  // One task a thread, which has its own workspace, takes one marker after the other.
  std::atomic<size_t> next{0};
  workers.For(options.threads, [&](int thread) {
    PhotometricWorkspace& workspace = photometric[static_cast<size_t>(thread)];
    for (size_t i = next++; i < detections->size(); i = next++) {
      Detection& detection = (*detections)[i];
      if (!detection.pose) continue;
      RefinePhotometric(frame.Of(detection.inverted), *camera(),
                        TagSize(options, detection.family, detection.id), &workspace, &detection);
      if (detection.inverted) UndoComplement(&*detection.pose->photometric);
    }
  });
}

Detector::Detector(Options options) : impl_(std::make_unique<Impl>(std::move(options))) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

Detector::Impl& Detector::impl() const {
  if (impl_ == nullptr) FailArgument("the detector has been moved from");
  return *impl_;
}

std::vector<Detection> Detector::detect(const ImageView& image) {
  std::vector<Detection> detections;
  detect(image, &detections);
  return detections;
}

void Detector::Impl::TakeFrom(FrameSource* from) {
  if (source == from) return;
  backend_name = from == nullptr ? backend->name() : from->backend()->name();
  source = from;
}

void Detector::Impl::Detect(const ImageView& image, const Rect& area,
                            std::vector<Detection>* detections) {
  try {
    RunStages(image, area, detections);
  } catch (...) {
    detections->clear();
    // It may have been thrown before the backend's part of a submitted frame.
    CurrentBackend()->KeepSubmitted(pending.size());
    throw;
  }
}

void Detector::Impl::RunStages(const ImageView& image, const Rect& area,
                               std::vector<Detection>* detections) {
  times = {};
  StopWatch total;
  FrameViews frame{image, {}};
  marker_count = 0;
  places.Start(image.width, image.height);
  pass = {CurrentBackend(), &first, source, false, 0};
  Search(image, area);
  if (complement_search) {
    StopWatch watch;
    const Rect all{0, 0, image.width, image.height};
    if (pass.source != nullptr) {
      parts.assign(1, all);
      pass.source->Fetch(parts);
    }
    // A marker that the region of interest cuts may reach any distance beyond it.
    frame.complement = Complement(image, options.roi ? all : area);
    times.threshold += watch.Lap();
    pass = {complement_search->backend.get(), &complement_search->segmentation, nullptr, true, 0};
    Search(frame.complement, area);
  }
  StopWatch watch;
  MeasureVertices(frame);
  Report(detections);
  times.vertices = watch.Lap();
  EstimatePoses(detections);
  if (options.pose == PoseMode::kPhotometric) RefinePoses(frame, detections);
  times.pose = watch.Lap();
  times.total = total.Lap();
}

void Detector::detect(const ImageView& image, std::vector<Detection>* detections) {
  RequireNotNull(detections, "detections");
  detections->clear();
  Impl& impl = this->impl();
  const DetectorUse use(&impl.one_thread);
  if (!impl.pending.empty()) FailArgument("detect: submitted frames have not been collected");
  const Rect area = impl.Area(image);
  impl.TakeFrom(nullptr);
  impl.Detect(impl.Prepared(image), area, detections);
}

void Detector::submit(const ImageView& image) {
  Impl& impl = this->impl();
  const DetectorUse use(&impl.one_thread);
  if (impl.pending.size() == static_cast<size_t>(kMaxSubmitted)) {
    FailArgument("submit: " + std::to_string(kMaxSubmitted) + " frames have not been collected");
  }
  const Rect area = impl.Area(image);
  impl.pending.reserve(kMaxSubmitted);
  const ImageView prepared = impl.Prepared(image);
  impl.backend->Submit(Crop(prepared, area), impl.threshold_params);
  impl.pending.push_back({prepared, area, impl.threshold_params.min_contrast});
  impl.next_smoothed = (impl.next_smoothed + 1) % impl.smoothed.size();
}

bool Detector::collect(std::vector<Detection>* detections) {
  RequireNotNull(detections, "detections");
  detections->clear();
  Impl& impl = this->impl();
  const DetectorUse use(&impl.one_thread);
  if (impl.pending.empty()) return false;
  impl.TakeFrom(nullptr);
  const Pending frame = impl.pending.front();
  impl.pending.erase(impl.pending.begin());
  impl.threshold_params.min_contrast = frame.min_contrast;
  impl.Detect(frame.image, frame.area, detections);
  return true;
}

bool Detector::refine(const ImageView& image, Detection* detection) {
  RequireNotNull(detection, "detection");
  Impl& impl = this->impl();
  const DetectorUse use(&impl.one_thread);
  impl.Area(image);
  if (impl.camera() == nullptr || !detection->pose) return false;
  ValidatePosed(*detection);
  const double size = TagSize(impl.options, detection->family, detection->id);
  if (size == 0) return false;
  Detection refined = *detection;
  ImageView pixels = image;
  // All of it: the pose says what is read, and the user may have predicted it.
  if (refined.inverted) pixels = impl.Complement(image, {0, 0, image.width, image.height});
  PhotometricWorkspace* const workspace = &impl.photometric[0];
  if (!RefinePhotometric(pixels, *impl.camera(), size, workspace, &refined)) return false;
  if (refined.inverted) UndoComplement(&*refined.pose->photometric);
  *detection = refined;
  return true;
}

const Options& Detector::options() const { return impl().options; }
const std::string& Detector::backend() const { return impl().backend_name; }
const StageTimes& Detector::times() const { return impl().times; }

const char* Version() { return TOPOTAG_VERSION; }

}  // namespace topotag
