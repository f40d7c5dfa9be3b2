#include <algorithm>
#include <cmath>

#include "host/bits.h"
#include "host/detector_impl.h"
#include "host/local_map.h"
#include "host/partial.h"
#include "topotag/marker.h"

// Which markers there are in the whole area; second_look.cc goes on where there is doubt.

namespace topotag {
namespace {

// What decoding and refining read around a candidate: its surroundings within this margin, in
// pixels and in parts of its larger side. The white area has at least 13 units; nodes, their gaps
// and the frame, however the perspective moves them, stay within 3 units of it.
constexpr int kFetchMargin = 16;
constexpr int kFetchShare = 4;
// Broken markers that are tried in one frame, half a millisecond each: this bounds their time.
constexpr size_t kMaxBroken = 16;

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

Rect WithMargin(const Rect& box, const ImageView& frame) {
  const int margin = kFetchMargin + std::max(box.width, box.height) / kFetchShare;
  const int x0 = std::max(box.x - margin, 0);
  const int y0 = std::max(box.y - margin, 0);
  return {x0, y0, std::min(box.x + box.width + margin, frame.width) - x0,
          std::min(box.y + box.height + margin, frame.height) - y0};
}

void Detector::Impl::Search(const ImageView& image, const Rect& whole) {
  pass.first_marker = marker_count;
  broken_left = kMaxBroken;
  pass.segmentation->Run(pass.backend, Crop(image, whole), threshold_params, &times);
  if (pass.source != nullptr) FetchCandidates(whole);
  DecodeCandidates(image, *pass.segmentation, {whole.x, whole.y, 1, whole});
  if (options.preset == Preset::kPaper) return;
  SecondLooks(image, whole);
  if (far) ReadFar(image, whole);
}

ImageView Detector::Impl::Complement(const ImageView& image, const Rect& part) {
  const auto stride = static_cast<size_t>(image.width);
  const size_t pixels = stride * static_cast<size_t>(image.height), had = complement.capacity();
  complement.Reserve(pixels);
  // What is beyond the part is read where a marker is cut: not what the memory was used for before.
  if (complement.capacity() != had) std::fill_n(complement.data(), pixels, uint8_t{0});
  const Rect area = WithMargin(part, image);
  for (int y = area.y; y < area.y + area.height; ++y) {
    const uint8_t* from = image.row(y) + area.x;
    uint8_t* to = complement.data() + static_cast<size_t>(y) * stride + area.x;
    for (int i = 0; i < area.width; ++i) to[i] = static_cast<uint8_t>(255 - from[i]);
  }
  return {complement.data(), image.width, image.height, image.width};
}

// Where only a part of the frame is searched, a marker may reach any distance beyond it.
void Detector::Impl::FetchCandidates(const Rect& whole) {
  StopWatch watch;
  const ImageView shadow = pass.source->shadow();
  if (whole.width < shadow.width || whole.height < shadow.height) {
    parts.assign(1, Rect{0, 0, shadow.width, shadow.height});
    pass.source->Fetch(parts);
    pass.source = nullptr;
    times.decode += watch.Lap();
    return;
  }
  parts.clear();
  for (const Candidate& candidate : pass.segmentation->tree.candidates()) {
    const Feature& white = candidate.white;
    const Rect box{whole.x + white.min_x, whole.y + white.min_y, white.max_x - white.min_x + 1,
                   white.max_y - white.min_y + 1};
    parts.push_back(WithMargin(box, shadow));
  }
  pass.source->Fetch(parts);
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
