#include "topotag/detector.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "host/bits.h"
#include "host/check.h"
#include "host/detector_impl.h"
#include "host/pose.h"
#include "host/sample.h"
#include "host/vertices.h"

namespace topotag {
namespace {

// A doubtful white area is looked at again, a small one in twice the resolution, with thresholds
// as before, nearer to its white (holes that ran into a gap close), and nearer to its black (holes
// that vanished open).
constexpr int kSecondLookSixteenths[] = {7, 8, 6};
constexpr int64_t kMaxUpsampledArea = 160 * 160;  // pixels
// All second looks of a frame together cover at most a quarter of it, or so many small areas: this
// bounds their time.
constexpr int64_t kSecondLookShare = 4;
constexpr int64_t kMinSecondLook = 4 * kMaxUpsampledArea;
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
  if (options.threads < 1) {
    FailArgument("threads " + std::to_string(options.threads) + " is less than 1");
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

// Two readings of the same place: their centres are less than half a pitch apart.
bool IsSameMarker(const Decoded& a, const Decoded& b) {
  const LocalMap local(a.map, {0, 0});
  const Point2 other = b.map.Pixel({0, 0});
  const double dx = other.x - local.center.x;
  const double dy = other.y - local.center.y;
  return dx * dx + dy * dy < 4 * std::abs(local.Determinant());
}

}  // namespace

Detector::Impl::Impl(Options o)
    : options(Validated(std::move(o))),
      workers(options.threads),
      backend(MakeBackend(options.backend, &workers)),
      second_backend(MakeBackend(options.backend, &workers)),
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
  decoded.clear();
  first.Run(backend.get(), Crop(image, whole), threshold_params, &times);
  DecodeCandidates(image, first, {whole.x, whole.y, 1, whole});
  if (options.preset == Preset::kPaper) return;
  int64_t budget = std::max(int64_t{whole.width} * whole.height / kSecondLookShare, kMinSecondLook);
  for (const Doubt& doubt : first.tree.doubts()) {
    const Feature& white = doubt.white;
    const int x0 = std::max(white.min_x - kTile, 0);
    const int y0 = std::max(white.min_y - kTile, 0);
    const int x1 = std::min(white.max_x + kTile, whole.width - 1);
    const int y1 = std::min(white.max_y + kTile, whole.height - 1);
    const Rect part{whole.x + x0, whole.y + y0, x1 - x0 + 1, y1 - y0 + 1};
    const int64_t cost = int64_t{part.width} * part.height;
    if (cost > budget) continue;
    budget -= cost;
    LookAgain(image, whole, part);
  }
}

void Detector::Impl::LookAgain(const ImageView& image, const Rect& whole, const Rect& part) {
  StopWatch watch;
  const bool small = int64_t{part.width} * part.height <= kMaxUpsampledArea;
  const ImageView view = small ? Upsample(Crop(image, part), &upsampled) : Crop(image, part);
  times.threshold += watch.Lap();
  ThresholdParams params = threshold_params;
  const size_t before = decoded.size();
  for (const int sixteenths : kSecondLookSixteenths) {
    if (!small && sixteenths == threshold_params.contrast_sixteenths) continue;
    params.contrast_sixteenths = sixteenths;
    second.Run(second_backend.get(), view, params, &times);
    DecodeCandidates(image, second, {part.x, part.y, small ? 2 : 1, whole});
    if (decoded.size() > before) return;
  }
}

void Detector::Impl::DecodeCandidates(const ImageView& image, const Segmentation& segmentation,
                                      const SearchArea& area) {
  StopWatch watch;
  for (const Candidate& candidate : segmentation.tree.candidates()) {
    Decoded one;
    if (Decode(candidate, segmentation.tree.nodes(candidate), camera(), area, &one) &&
        ConfirmBits(image, &one) &&
        std::none_of(decoded.begin(), decoded.end(),
                     [&](const Decoded& other) { return IsSameMarker(one, other); })) {
      decoded.push_back(one);
    }
  }
  times.decode += watch.Lap();
}

void Detector::Impl::MeasureVertices(const ImageView& image, std::vector<Detection>* detections) {
  detections->resize(decoded.size());
  for (size_t i = 0; i < decoded.size(); ++i) {
    Decoded& one = decoded[i];
    Detection& detection = (*detections)[i];
    RefineVertices(image, &one, &detection.vertices);
    detection.family = one.family;
    detection.id = one.id;
    detection.center = one.map.Pixel({0, 0});
    const double half = one.family.white_side() / 2.0;
    detection.corners = {one.map.Pixel({-half, -half}), one.map.Pixel({half, -half}),
                         one.map.Pixel({half, half}), one.map.Pixel({-half, half})};
  }
}

void Detector::Impl::EstimatePoses(std::vector<Detection>* detections) {
  for (size_t i = 0; i < decoded.size(); ++i) {
    Detection& detection = (*detections)[i];
    detection.pose.reset();
    const double size = TagSize(detection.family, detection.id);
    if (camera() == nullptr || size == 0) continue;
    Pose pose;
    if (EstimatePose(detection.family, detection.vertices, decoded[i].map.ideal, *camera(), size,
                     &pose)) {
      detection.pose = pose;
    }
  }
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

void Detector::detect(const ImageView& image, std::vector<Detection>* detections) {
  detections->clear();
  const Rect area = impl_->Area(image);
  impl_->times = {};
  StopWatch total;
  impl_->Search(image, area);
  StopWatch watch;
  impl_->MeasureVertices(image, detections);
  impl_->times.vertices = watch.Lap();
  impl_->EstimatePoses(detections);
  impl_->times.pose = watch.Lap();
  std::sort(detections->begin(), detections->end(), [](const Detection& a, const Detection& b) {
    const auto key = [](const Detection& d) {
      return std::make_tuple(d.family.n(), d.id, d.center.y, d.center.x);
    };
    return key(a) < key(b);
  });
  impl_->times.total = total.Lap();
}

const Options& Detector::options() const { return impl_->options; }
const std::string& Detector::backend() const { return impl_->backend_name; }
const StageTimes& Detector::times() const { return impl_->times; }

const char* Version() { return TOPOTAG_VERSION; }

}  // namespace topotag
