#include <algorithm>
#include <cmath>

#include "host/bits.h"
#include "host/detector_impl.h"
#include "host/local_map.h"
#include "host/mean_side.h"
#include "host/partial.h"
#include "host/second_look.h"
#include "topotag/marker.h"

// Which markers there are: first in the whole area, then again where there is doubt.

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
// What decoding and refining read around a candidate: its surroundings within this margin, in
// pixels and in parts of its larger side. The white area has at least 13 units; nodes, their gaps
// and the frame, however the perspective moves them, stay within 3 units of it.
constexpr int kFetchMargin = 16;
constexpr int kFetchShare = 4;
// Broken markers that are tried in one frame, half a millisecond each: this bounds their time.
constexpr size_t kMaxBroken = 16;
constexpr double kBaselineArea = 15;  // square units
constexpr double kReach = 1.15;       // of a marker from its baseline node, sides: perspective

// A box grown by the margin of what is read around it, within the frame.
Rect WithMargin(const Rect& box, const ImageView& frame) {
  const int margin = kFetchMargin + std::max(box.width, box.height) / kFetchShare;
  const int x0 = std::max(box.x - margin, 0);
  const int y0 = std::max(box.y - margin, 0);
  return {x0, y0, std::min(box.x + box.width + margin, frame.width) - x0,
          std::min(box.y + box.height + margin, frame.height) - y0};
}

// A part of the frame grown by its larger side in all directions.
Rect Grown(const Rect& part, const Rect& whole) {
  const int margin = std::max(part.width, part.height);
  const int x0 = std::max(part.x - margin, whole.x);
  const int y0 = std::max(part.y - margin, whole.y);
  const int x1 = std::min(part.x + part.width + margin, whole.x + whole.width);
  const int y1 = std::min(part.y + part.height + margin, whole.y + whole.height);
  return {x0, y0, x1 - x0, y1 - y0};
}

// Whether a reading is of a place that a marker was read at: the centres are less than half a pitch
// apart.
bool IsKnown(const PlaceGrid& places, const Decoded& decoded) {
  const LocalMap local(decoded.map, {0, 0});
  return places.HasNear(local.center, 4 * std::abs(local.Determinant()));
}

// Of a marker whose holes are known by its model: how bright one is follows from the blur.
Quality QualityOf(const FarMarker& marker) {
  const FarReading& reading = marker.reading;
  Jacobian2 j;
  reading.map.Map({0, 0}, &j);
  const double unit = std::sqrt(std::abs(j[0] * j[3] - j[1] * j[2]));
  const double part = std::erf(unit / (2 * std::sqrt(2.0) * reading.blur));
  return {reading.white - reading.black, std::clamp(reading.min_step, 0.0, 1.0), part * part, 0};
}

}  // namespace

void Detector::Impl::Search(const ImageView& image, const Rect& whole) {
  pass.first_marker = marker_count;
  broken_left = kMaxBroken;
  pass.segmentation->Run(pass.backend, Crop(image, whole), threshold_params, &times);
  if (pass.source != nullptr) FetchCandidates(whole);
  DecodeCandidates(image, *pass.segmentation, {whole.x, whole.y, 1, whole});
  if (options.preset == Preset::kPaper) return;
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
  if (far) ReadFar(image, whole);
}

ImageView Detector::Impl::Complement(const ImageView& image, const Rect& part) {
  const auto stride = static_cast<size_t>(image.width);
  complement.Reserve(stride * static_cast<size_t>(image.height));
  const Rect area = WithMargin(part, image);
  for (int y = area.y; y < area.y + area.height; ++y) {
    const uint8_t* from = image.row(y) + area.x;
    uint8_t* to = complement.data() + static_cast<size_t>(y) * stride + area.x;
    for (int i = 0; i < area.width; ++i) to[i] = static_cast<uint8_t>(255 - from[i]);
  }
  return {complement.data(), image.width, image.height, image.width};
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

void Detector::Impl::FetchCandidates(const Rect& whole) {
  StopWatch watch;
  parts.clear();
  for (const Candidate& candidate : pass.segmentation->tree.candidates()) {
    const Feature& white = candidate.white;
    const Rect box{whole.x + white.min_x, whole.y + white.min_y, white.max_x - white.min_x + 1,
                   white.max_y - white.min_y + 1};
    parts.push_back(WithMargin(box, pass.source->shadow()));
  }
  pass.source->Fetch(parts);
  times.decode += watch.Lap();
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

void Detector::Impl::ReadFar(const ImageView& image, const Rect& whole) {
  StopWatch watch;
  far->Start(whole, pass.backend->Grid());
  for (size_t i = 0; i < marker_count; ++i) {
    const Decoded& decoded = markers[i].decoded;
    far->Exclude(WhiteCorners(decoded.map, decoded.family));
  }
  const auto add_white = [&](uint32_t root, const Feature& white) {
    if (far->IsKnown({whole.x + (white.min_x + white.max_x) / 2.0,
                      whole.y + (white.min_y + white.max_y) / 2.0})) {
      return;
    }
    Point2 quad[4];
    if (!outline.Find(pass.segmentation->components, root, white, quad)) return;
    for (Point2& corner : quad) corner = {corner.x + whole.x, corner.y + whole.y};
    far->AddQuad(quad);
  };
  for (const Doubt& doubt : pass.segmentation->tree.doubts()) add_white(doubt.root, doubt.white);
  for (const Candidate& candidate : pass.segmentation->tree.candidates()) {
    add_white(candidate.root, candidate.white);
  }
  if (pass.source != nullptr && far->IsNeeded()) {
    parts.assign(1, far->Area());
    pass.source->Fetch(parts);
  }
  for (const FarMarker& found : far->Run(image, camera())) {
    if (markers.size() == marker_count) markers.emplace_back();
    Marker& marker = markers[marker_count];
    marker.is_read = true;
    marker.decoded.family = found.family;
    marker.decoded.id = IdFromVertexBits(found.family, found.reading.bits);
    marker.decoded.map = {found.reading.map, camera()};
    marker.decoded.hidden = marker.decoded.unmeasured = 0;
    marker.decoded.quality = QualityOf(found);
    marker.far = found.reading;
    KeepMarker(marker_count, true);
  }
  times.decode += watch.Lap();
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
  unread.clear();
  for (size_t i = 0; i < candidates.size() && unread.size() < broken_left; ++i) {
    if (!markers[marker_count + i].is_read) unread.push_back(i);
  }
  broken_left -= unread.size();
  workers.For(static_cast<int>(unread.size()), [&](int k) {
    const size_t i = unread[static_cast<size_t>(k)];
    const Candidate& candidate = candidates[i];
    Marker& marker = markers[marker_count + i];
    const Node* nodes = segmentation.tree.nodes(candidate);
    marker.is_read =
        ReadBroken(image, nodes, candidate.node_count,
                   area.CentroidInFrame(nodes[candidate.baseline].black), area, &marker);
  });
  const size_t begin = marker_count;
  for (size_t i = begin; i < end; ++i) KeepMarker(i, false);
  times.decode += watch.Lap();
}

// Keeps a marker that has been read at markers[i], i >= marker_count, where it is a new one.
void Detector::Impl::KeepMarker(size_t i, bool is_far) {
  Marker& marker = markers[i];
  if (!marker.is_read || !ids.Admit(&marker.decoded) || IsKnown(places, marker.decoded)) return;
  marker.is_far = is_far;
  marker.is_inverted = pass.inverted;
  marker.center = marker.decoded.map.Pixel({0, 0});
  places.Add(marker.center);
  if (i != marker_count) markers[marker_count] = marker;
  ++marker_count;
}

// What decoding has not read may be a marker of which something is in the way.
bool Detector::Impl::ReadBroken(const ImageView& image, const Node* nodes, int count, Point2 start,
                                const SearchArea& area, Marker* marker) const {
  return options.preset != Preset::kPaper &&
         ReadPartial(image, options.families, nodes, count, camera(), area, start,
                     options.hidden_nodes, &marker->decoded);
}

}  // namespace topotag
