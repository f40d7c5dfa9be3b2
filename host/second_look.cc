#include "host/second_look.h"

#include <algorithm>
#include <cmath>

#include "host/detector_impl.h"
#include "host/mean_side.h"

// Where a search left doubts: the same part of the frame again, larger and with other thresholds.

namespace topotag {
namespace {

// A doubtful white area is looked at again, a small one in twice the resolution, with thresholds
// as before, nearer to its white (holes that ran into a gap close), and nearer to its black (holes
// that vanished open). Where nothing like a marker is left, other thresholds bring none.
constexpr int kSecondLookSixteenths[] = {7, 8, 6};
// White in a shadow of a third of the light is brighter than this part of the way from black to
// white in the light.
constexpr int kShadowSixteenths = 3;
constexpr int64_t kMaxUpsampledArea = 160 * 160;  // pixels
// All second looks of a frame may cover this many pixels, whatever its size.
constexpr int64_t kMinSecondLook = 4 * kMaxUpsampledArea;
constexpr double kBaselineArea = 15;  // square units
constexpr double kReach = 1.15;       // of a marker from its baseline node, sides: perspective

// A part of the frame grown by its larger side in all directions.
Rect Grown(const Rect& part, const Rect& whole) {
  const int margin = std::max(part.width, part.height);
  const int x0 = std::max(part.x - margin, whole.x);
  const int y0 = std::max(part.y - margin, whole.y);
  const int x1 = std::min(part.x + part.width + margin, whole.x + whole.width);
  const int y1 = std::min(part.y + part.height + margin, whole.y + whole.height);
  return {x0, y0, x1 - x0, y1 - y0};
}

}  // namespace

void Detector::Impl::SecondLooks(const ImageView& image, const Rect& whole) {
  int64_t budget = std::max(int64_t{whole.width} * whole.height / kSecondLookShare, kMinSecondLook);
  for (const Doubt& doubt : pass.segmentation->tree.doubts()) {
    const Feature& white = doubt.white;
    const int x0 = std::max(white.min_x - kSecondLookMargin, 0);
    const int y0 = std::max(white.min_y - kSecondLookMargin, 0);
    const int x1 = std::min(white.max_x + kSecondLookMargin, whole.width - 1);
    const int y1 = std::min(white.max_y + kSecondLookMargin, whole.height - 1);
    const Rect part{whole.x + x0, whole.y + y0, x1 - x0 + 1, y1 - y0 + 1};
    const int64_t cost = int64_t{part.width} * part.height;
    if (cost > budget) continue;
    budget -= cost;
    LookAgain(image, whole, part, doubt.has_holes);
  }
  for (const LostBaseline& lost : pass.segmentation->tree.lost_baselines()) {
    const Rect part = ReachOf(lost, whole);
    const int64_t cost = int64_t{part.width} * part.height;
    if (cost == 0 || cost > budget) continue;
    budget -= cost;
    LookAround(image, whole, part, {whole.x + lost.center.x, whole.y + lost.center.y},
               threshold_params.contrast_sixteenths);
  }
  LookIntoShade(image, whole);
}

// Where no marker was found at all, but nodes with holes are in sight, a shadow may have cut them
// off from the rest of theirs: the threshold goes between the white in the shadow and the black in
// the light.
void Detector::Impl::LookIntoShade(const ImageView& image, const Rect& whole) {
  if (marker_count != pass.first_marker) return;
  int64_t budget = std::max(int64_t{whole.width} * whole.height / kShadeShare, kMinSecondLook);
  const std::vector<Doubt>& doubts = pass.segmentation->tree.doubts();
  const std::vector<LostBaseline>& lost_baselines = pass.segmentation->tree.lost_baselines();
  if (lost_baselines.empty() &&
      std::none_of(doubts.begin(), doubts.end(), [](const Doubt& d) { return d.has_holes; })) {
    return;
  }
  for (const Doubt& doubt : doubts) {
    const Feature& white = doubt.white;
    const Rect part{whole.x + white.min_x, whole.y + white.min_y, white.max_x - white.min_x + 1,
                    white.max_y - white.min_y + 1};
    const Rect wide = Grown(part, whole);
    const int64_t cost = int64_t{wide.width} * wide.height;
    if (cost > budget) continue;
    budget -= cost;
    LookAround(image, whole, wide, {part.x + part.width / 2.0, part.y + part.height / 2.0},
               kShadowSixteenths);
    if (marker_count != pass.first_marker) return;
  }
  for (const LostBaseline& lost : lost_baselines) {
    const Rect part = ReachOf(lost, whole);
    const int64_t cost = int64_t{part.width} * part.height;
    if (cost == 0 || cost > budget) continue;
    budget -= cost;
    LookAround(image, whole, part, {whole.x + lost.center.x, whole.y + lost.center.y},
               kShadowSixteenths);
    if (marker_count != pass.first_marker) return;
  }
}

// The pixels of a part of the frame for a second look, a small one in twice the resolution.
ImageView Detector::Impl::Enlarged(const ImageView& image, const Rect& part, int* scale) {
  StopWatch watch;
  if (pass.source != nullptr) {
    parts.assign(1, WithMargin(part, image));
    pass.source->Fetch(parts);
  }
  *scale = int64_t{part.width} * part.height <= kMaxUpsampledArea ? 2 : 1;
  const ImageView view = Crop(image, part);
  const ImageView result = *scale == 2 ? Upsample(view, &upsampled) : view;
  times.threshold += watch.Lap();
  return result;
}

// Unless nodes with holes are in sight, nothing that may be broken is read.
void Detector::Impl::LookAgain(const ImageView& image, const Rect& whole, const Rect& part,
                               bool has_holes) {
  int scale;
  const ImageView view = Enlarged(image, part, &scale);
  ThresholdParams params = threshold_params;
  const SearchArea area{part.x, part.y, scale, whole};
  const size_t before = marker_count;
  bool is_first = true;
  for (const int sixteenths : kSecondLookSixteenths) {
    if (scale == 1 && sixteenths == threshold_params.contrast_sixteenths) continue;
    params.contrast_sixteenths = sixteenths;
    second.Run(second_backend.get(), view, params, &times);
    DecodeCandidates(image, second, area);
    if (marker_count > before) return;
    if (is_first) broken.Find(second.components, second_backend.get());
    is_first = false;
    if (second.tree.candidates().empty() && second.tree.doubts().empty()) break;
  }
  if (!has_holes && !broken.sees_baseline()) return;
  ReadBrokenNodes(image, {part.x + part.width / 2.0, part.y + part.height / 2.0}, area);
}

// Part of the frame. Foreshortening makes units differ in the two directions.
Rect Detector::Impl::ReachOf(const LostBaseline& lost, const Rect& whole) const {
  const double along = std::hypot(lost.p2.x - lost.p1.x, lost.p2.y - lost.p1.y) / 2;
  const double across = lost.area / kBaselineArea / along;
  const double length = kReach * options.families.back().white_side() * std::max(along, across);
  if (length < kSurelySmaller * options.min_size) return {};
  const int reach = static_cast<int>(std::min(length, double{kMaxImageSide}));
  const int x = static_cast<int>(lost.center.x);
  const int y = static_cast<int>(lost.center.y);
  const int x0 = std::max(x - reach, 0);
  const int y0 = std::max(y - reach, 0);
  const int x1 = std::min(x + reach, whole.width - 1);
  const int y1 = std::min(y + reach, whole.height - 1);
  return {whole.x + x0, whole.y + y0, x1 - x0 + 1, y1 - y0 + 1};
}

// Looks for a marker of which only a part, or only the baseline node, came out in one piece.
void Detector::Impl::LookAround(const ImageView& image, const Rect& whole, const Rect& part,
                                Point2 start, int contrast_sixteenths) {
  int scale;
  const ImageView view = Enlarged(image, part, &scale);
  const SearchArea area{part.x, part.y, scale, whole};
  ThresholdParams params = threshold_params;
  const size_t before = marker_count;
  params.contrast_sixteenths = contrast_sixteenths;
  second.Run(second_backend.get(), view, params, &times);
  DecodeCandidates(image, second, area);
  if (marker_count > before) return;
  broken.Find(second.components, second_backend.get());
  ReadBrokenNodes(image, start, area);
}

// Reads a marker from the collected nodes, near to `start` first.
void Detector::Impl::ReadBrokenNodes(const ImageView& image, Point2 start, const SearchArea& area) {
  if (broken_left == 0) return;
  --broken_left;
  StopWatch watch;
  if (markers.size() == marker_count) markers.emplace_back();
  Marker& marker = markers[marker_count];
  const std::vector<Node>& nodes = broken.nodes();
  marker.is_read =
      ReadBroken(image, nodes.data(), static_cast<int>(nodes.size()), start, area, &marker);
  KeepMarker(marker_count, false);
  times.decode += watch.Lap();
}

}  // namespace topotag
