// Start of the bundle adjustment, and the rounds of choosing what contradicts the others.
#include "topotag/object_calibration.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host/check.h"
#include "host/object_bundle.h"
#include "host/object_frame.h"
#include "host/object_links.h"
#include "host/object_name.h"
#include "host/object_sighting.h"

namespace topotag {
namespace {

constexpr int kMaxRounds = 4;

// The markers of one view; of those that are there twice, none.
std::vector<Sighting> FindSightings(const Object& object, const ObjectIndex& index,
                                    const ObjectView& view) {
  std::vector<int> count(object.markers.size());
  for (const Detection& detection : view.detections) {
    const int marker = index.Find(detection.family, detection.id);
    if (marker >= 0) ++count[static_cast<size_t>(marker)];
  }
  std::vector<Sighting> sightings;
  for (size_t i = 0; i < view.detections.size(); ++i) {
    const Detection& detection = view.detections[i];
    Sighting one;
    one.detection = static_cast<int>(i);
    one.marker = index.Find(detection.family, detection.id);
    if (one.marker < 0 || count[static_cast<size_t>(one.marker)] > 1) continue;
    const double tag_size = object.markers[static_cast<size_t>(one.marker)].tag_size;
    if (MakeSighting(detection, view.camera, tag_size, &one)) sightings.push_back(one);
  }
  return sightings;
}

// Whether one of the sightings is of a marker.
bool Shows(const std::vector<Sighting>& sightings, size_t marker) {
  return std::any_of(sightings.begin(), sightings.end(),
                     [&](const Sighting& one) { return one.marker == static_cast<int>(marker); });
}

// Calibration of one object.
class Calibration {
 public:
  Calibration(const Object& start, const std::vector<ObjectView>& views, ObjectFrame frame)
      : views_(views), frame_(frame), object_(start), start_(start), index_(start) {
    for (const ObjectView& view : views) {
      ValidateCamera(view.camera);
      sightings_.push_back(FindSightings(start, index_, view));
    }
  }

  ObjectCalibration Run() {
    CheckSeen();
    Join();
    for (int round = 0; round < kMaxRounds; ++round) {
      if (!SelectViews() && round > 0) break;
      ObjectBundle bundle(&markers_, &bundle_views_);
      if (!bundle.Adjust()) FailArgument("the views do not determine the object");
      SetPoses();
    }
    return Report();
  }

 private:
  std::string NameOf(size_t marker) const {
    return MarkerName(object_.markers[marker].family, object_.markers[marker].id);
  }
  using Links = std::map<std::pair<size_t, size_t>, Link>;
  Links FindLinks() const;
  void CheckSeen() const;
  void Join();
  bool SelectViews();
  void SetPoses();
  void ChangeFrame(const RigidTransform& change);
  ObjectCalibration Report();
  void SetCovariance(ObjectCalibration* result);

  const std::vector<ObjectView>& views_;
  const ObjectFrame frame_;
  Object object_;
  const Object& start_;
  const ObjectIndex index_;
  std::vector<std::vector<Sighting>> sightings_;  ///< of each view
  std::vector<RigidTransform> markers_;
  std::vector<BundleView> bundle_views_;
  std::vector<std::vector<int>> used_;  ///< detections of each view
  int rejected_ = 0;
};

// The best link of each pair of markers that is seen, first the smaller index.
Calibration::Links Calibration::FindLinks() const {
  std::map<std::pair<size_t, size_t>, std::vector<PairView>> pairs;
  for (const std::vector<Sighting>& view : sightings_) {
    for (const Sighting& a : view) {
      for (const Sighting& b : view) {
        if (a.marker >= b.marker) continue;
        pairs[{static_cast<size_t>(a.marker), static_cast<size_t>(b.marker)}].push_back(
            {std::min(a.side, b.side), &a, &b});
      }
    }
  }
  Links links;
  for (auto& [pair, views] : pairs) {
    const double size =
        object_.markers[pair.first].tag_size + object_.markers[pair.second].tag_size;
    links[pair] = BestLink(std::move(views), size);
  }
  return links;
}

// What the views cannot give, before anything is made of them.
void Calibration::CheckSeen() const {
  if (object_.markers.size() < 2) {
    FailArgument("the object has one marker: there is nothing to measure");
  }
  if (views_.empty()) FailArgument("there is no view of the object");
  std::vector<bool> seen(object_.markers.size());
  for (const std::vector<Sighting>& view : sightings_) {
    for (const Sighting& one : view) seen[static_cast<size_t>(one.marker)] = true;
  }
  const auto lost = std::find(seen.begin(), seen.end(), false);
  if (lost != seen.end()) {
    FailArgument(NameOf(static_cast<size_t>(lost - seen.begin())) + " is in no view");
  }
}

// Sets the markers' first poses along the chains of links from the first marker that leave the
// least doubt (Dijkstra).
void Calibration::Join() {
  const Links links = FindLinks();
  const Link no_link{};
  const size_t count = object_.markers.size();
  std::vector<bool> joined(count);
  std::vector<double> doubt(count, INFINITY);
  std::vector<size_t> before(count);
  doubt[0] = 0;
  for (size_t step = 0; step < count; ++step) {
    size_t to = count;
    for (size_t i = 0; i < count; ++i) {
      if (!joined[i] && doubt[i] < (to == count ? INFINITY : doubt[to])) to = i;
    }
    if (to == count) {
      const auto lost = std::find(joined.begin(), joined.end(), false) - joined.begin();
      FailArgument(NameOf(static_cast<size_t>(lost)) + " is in no view together with " + NameOf(0) +
                   " or what is joined to it");
    }
    const auto link = [&](size_t k) -> const Link& {
      const auto found = links.find({std::min(to, k), std::max(to, k)});
      return found == links.end() ? no_link : found->second;
    };
    if (to != 0) {
      const size_t from = before[to];
      const RigidTransform& pose = link(from).pose;
      const ObjectMarker& base = object_.markers[from];
      const RigidTransform placed =
          RigidTransform{base.R, base.t} * (from < to ? pose : pose.Inverse());
      object_.markers[to].R = Orthonormalized(placed.R);
      object_.markers[to].t = placed.t;
    }
    for (size_t k = 0; k < count; ++k) {
      const double through = doubt[to] + link(k).Doubt();
      if (joined[k] || !(through < doubt[k])) continue;
      doubt[k] = through;
      before[k] = to;
    }
    joined[to] = true;
  }
}

// Finds the object, as it is known, in every view, and what of it to use there.
// @return whether that is other than before
bool Calibration::SelectViews() {
  std::vector<std::vector<int>> used(views_.size());
  bundle_views_.clear();
  markers_.clear();
  rejected_ = 0;
  for (const ObjectMarker& marker : object_.markers) markers_.push_back({marker.R, marker.t});
  for (size_t v = 0; v < views_.size(); ++v) {
    ObjectPoseEstimator estimator(object_, views_[v].camera);
    ObjectPose pose;
    if (!estimator.estimate(views_[v].detections, &pose)) continue;
    BundleView view{&views_[v].camera, {pose.R, pose.t}, {}};
    for (const Sighting& one : sightings_[v]) {
      if (std::binary_search(pose.used.begin(), pose.used.end(), one.detection)) {
        view.sightings.push_back(one);
      } else {
        ++rejected_;
      }
    }
    // A marker alone says nothing of the others.
    if (view.sightings.size() < 2) continue;
    used[v] = pose.used;
    bundle_views_.push_back(std::move(view));
  }
  for (size_t i = 0; i < markers_.size(); ++i) {
    const bool is_used =
        std::any_of(bundle_views_.begin(), bundle_views_.end(),
                    [&](const BundleView& view) { return Shows(view.sightings, i); });
    if (!is_used) FailArgument(NameOf(i) + " agrees with the others in no view");
  }
  const bool changed = used != used_;
  used_ = std::move(used);
  return changed;
}

void Calibration::SetPoses() {
  for (size_t i = 0; i < markers_.size(); ++i) {
    object_.markers[i].R = markers_[i].R;
    object_.markers[i].t = markers_[i].t;
  }
}

// Takes everything from the object's frame to another one.
void Calibration::ChangeFrame(const RigidTransform& change) {
  for (RigidTransform& marker : markers_) marker = change * marker;
  for (BundleView& view : bundle_views_) view.pose = view.pose * change.Inverse();
  SetPoses();
}

ObjectCalibration Calibration::Report() {
  ObjectCalibration result;
  result.sightings.assign(markers_.size(), 0);
  result.views = static_cast<int>(bundle_views_.size());
  result.rejected = rejected_;
  double squares = 0;
  int vertices = 0;
  for (const BundleView& view : bundle_views_) {
    for (const Sighting& one : view.sightings) {
      const size_t marker = static_cast<size_t>(one.marker);
      ++result.sightings[marker];
      squares += ReprojectionSquares(*view.camera, view.pose * markers_[marker], one.vertices);
      vertices += one.vertices.pixels->size();
    }
  }
  result.rms_px = std::sqrt(squares / vertices);
  if (frame_ == ObjectFrame::kAllMarkers) ChangeFrame(FitFrame(object_, start_));
  SetCovariance(&result);
  result.object = object_;
  return result;
}

void Calibration::SetCovariance(ObjectCalibration* result) {
  ObjectBundle bundle(&markers_, &bundle_views_);
  std::vector<double> others;
  if (!bundle.Covariance(&others)) FailArgument("the views do not determine the object");
  const size_t side = 6 * markers_.size(), part = side - 6;
  std::vector<double> all(side * side);
  for (size_t i = 0; i < part; ++i) {
    for (size_t k = 0; k < part; ++k) all[(i + 6) * side + k + 6] = others[i * part + k];
  }
  if (frame_ == ObjectFrame::kAllMarkers) {
    result->covariance = CovarianceInFittedFrame(object_, all);
    return;
  }
  for (size_t m = 0; m < markers_.size(); ++m) {
    Matrix6& block = result->covariance.emplace_back();
    for (size_t i = 0; i < 6; ++i) {
      for (size_t k = 0; k < 6; ++k) block[i][k] = all[(6 * m + i) * side + 6 * m + k];
    }
  }
}

}  // namespace

ObjectCalibration CalibrateObject(const Object& start, const std::vector<ObjectView>& views,
                                  ObjectFrame frame) {
  ValidateObject(start);
  RequireEnum("frame", frame, ObjectFrame::kAllMarkers);
  return Calibration(start, views, frame).Run();
}

}  // namespace topotag
