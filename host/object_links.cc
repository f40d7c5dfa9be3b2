#include "host/object_links.h"

#include <algorithm>
#include <utility>

#include "host/planar_pose.h"

namespace topotag {
namespace {

// Relative poses of a pair of markers are taken from this many views, those that show it largest.
constexpr size_t kMaxPairViews = 12;
// Two relative poses agree: rotation in rad, position as a part of the markers' distance and size.
constexpr double kSameTurn = 0.1;
constexpr double kSamePlace = 0.1;

// The poses of each view that its markers' planar solutions allow.
std::vector<RigidTransform> RelativePoses(const PairView& view) {
  std::vector<RigidTransform> poses;
  for (int i = 0; i < view.first->pose_count; ++i) {
    for (int k = 0; k < view.second->pose_count; ++k) {
      poses.push_back(view.first->poses[i].Inverse() * view.second->poses[k]);
    }
  }
  return poses;
}

bool Agree(const RigidTransform& a, const RigidTransform& b, double size) {
  const Vector3 moved = a.t - b.t;
  const double reach = kSamePlace * (std::sqrt(Dot(a.t, a.t)) + size);
  return Dot(moved, moved) < reach * reach && RotationBetween(a.R, b.R) < kSameTurn;
}

// Mean of the nearest pose of each view that agrees with a pose.
RigidTransform MeanOfAgreeing(const RigidTransform& pose,
                              const std::vector<std::vector<RigidTransform>>& poses, double size) {
  RigidTransform sum{{}, {}};
  double count = 0;
  for (const std::vector<RigidTransform>& view : poses) {
    const auto nearest = std::min_element(
        view.begin(), view.end(), [&](const RigidTransform& a, const RigidTransform& b) {
          return RotationBetween(a.R, pose.R) < RotationBetween(b.R, pose.R);
        });
    if (!Agree(pose, *nearest, size)) continue;
    for (size_t i = 0; i < 3; ++i) sum.R[i] = sum.R[i] + nearest->R[i];
    sum.t = sum.t + nearest->t;
    ++count;
  }
  return {Orthonormalized(sum.R), Scaled(sum.t, 1 / count)};
}

}  // namespace

Link BestLink(std::vector<PairView> views, double size) {
  std::stable_sort(views.begin(), views.end(),
                   [](const PairView& a, const PairView& b) { return a.side > b.side; });
  if (views.size() > kMaxPairViews) views.resize(kMaxPairViews);
  std::vector<std::vector<RigidTransform>> poses;
  for (const PairView& view : views) poses.push_back(RelativePoses(view));
  Link best;
  for (size_t v = 0; v < views.size(); ++v) {
    for (const RigidTransform& pose : poses[v]) {
      Link link{0, views[v].side, pose};
      for (const auto& others : poses) {
        link.views += std::any_of(others.begin(), others.end(), [&](const RigidTransform& other) {
          return Agree(pose, other, size);
        });
      }
      if (link.IsBetterThan(best)) best = link;
    }
  }
  best.pose = MeanOfAgreeing(best.pose, poses, size);
  return best;
}

}  // namespace topotag
