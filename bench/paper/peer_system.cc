#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "bench/corner_pose.h"
#include "bench/paper/resized.h"
#include "bench/paper/systems.h"
#include "bench/peers.h"
#include "tests/scene_util.h"

namespace topotag::bench::paper {
namespace {

/// Sum of squared distances between corners and a pose's, square pixels; infinite for a pose that
/// does not put all of them in front of the camera.
double ReprojectionError(const std::array<Point2, 4>& corners, double side,
                         const PoseSolution& pose) {
  constexpr double kSigns[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  double sum = 0;
  for (size_t c = 0; c < 4; ++c) {
    Vector3 p = pose.t;
    for (size_t i = 0; i < 3; ++i) {
      p[i] += side / 2 * (pose.R[i][0] * kSigns[c][0] + pose.R[i][1] * kSigns[c][1]);
    }
    if (!(p[2] > 0)) return std::numeric_limits<double>::infinity();
    const Point2 projected = Project(PaperCamera(), {p[0] / p[2], p[1] / p[2]});
    sum += std::pow(test::Distance(projected, corners[c]), 2);
  }
  return sum;
}

/// IPPE, then Levenberg-Marquardt; IPPE's where that makes it worse, which happens with corners
/// that form an exact square.
std::optional<PoseSolution> BestOfCorners(const std::array<Point2, 4>& corners, double side) {
  std::optional<PoseSolution> best;
  double least = std::numeric_limits<double>::infinity();
  for (const bool refine : {false, true}) {
    const auto pose = PoseOfCorners(corners, side, PaperCamera(), refine);
    const double error = pose ? ReprojectionError(corners, side, *pose) : least;
    if (error < least) best = pose;
    least = std::min(least, error);
  }
  return best;
}

/// A peer's marker is as large as ours with one white cell around its black square. What its bitmap
/// has beyond that, because its detector needs it, comes on top.
class PeerSystem : public System {
 public:
  /// @param own_pose  whether the library has a function of its own for poses.
  PeerSystem(std::string name, std::unique_ptr<Peer> peer, bool own_pose)
      : name_(std::move(name)), peer_(std::move(peer)), own_pose_(own_pose) {
    const int cells = peer_->Marker(0).cells;
    const double black = peer_->black_share() * cells;
    core_side_ = kMarkerSide * black / (black + 2);
    const double outer = core_side_ * cells / black;
    const double white = design_.family.white_side();
    tag_size_ = outer * white / (white + 2 * design_.frame);
  }

  Who who() const override { return Who::kPeer; }
  std::string name() const override { return name_; }
  std::string description() const override { return peer_->description(); }
  uint64_t dictionary_size() const override {
    return static_cast<uint64_t>(peer_->dictionary_size());
  }
  std::vector<std::string> solvers() const override {
    if (own_pose_) return {"own", "IPPE + LM"};
    return {"IPPE + LM"};
  }
  double core_side() const override { return core_side_; }

  Image Render(const Scene& scene, uint64_t id) const override {
    return RenderBitmaps(WithDesign(scene, design_, tag_size_),
                         {peer_->Marker(static_cast<int>(id))});
  }

  std::vector<Point2> TruePoints(const Scene& scene) const override {
    const auto corners = GroundTruth(WithDesign(scene, design_, core_side_), 0).corners;
    return {corners.begin(), corners.end()};
  }

  void Find(const ImageView& frame, std::vector<Seen>* markers) override {
    peer_->Locate(frame, &found_);
    markers->clear();
    for (const Located& located : found_) {
      markers->push_back({static_cast<uint64_t>(located.id),
                          located.corners,
                          {located.corners.begin(), located.corners.end()},
                          {}});
    }
  }

  void Locate(const ImageView& frame, std::vector<Seen>* markers) override {
    Find(frame, markers);
    for (size_t i = 0; i < found_.size(); ++i) {
      for (size_t solver = 0; solver < solvers().size(); ++solver) {
        (*markers)[i].poses.push_back(Solve(i, solver));
      }
    }
  }

  int Run(const ImageView& frame, size_t solver) override {
    peer_->Locate(frame, &found_);
    for (size_t i = 0; i < found_.size(); ++i) Solve(i, solver);
    return static_cast<int>(found_.size());
  }

 private:
  std::optional<PoseSolution> Solve(size_t index, size_t solver) {
    if (own_pose_ && solver == 0) return peer_->OwnPose(index, PaperCamera(), core_side_);
    return BestOfCorners(found_[index].corners, core_side_);
  }

  std::string name_;
  std::unique_ptr<Peer> peer_;
  bool own_pose_;
  MarkerDesign design_;  // a place-holder, whose size is set
  double core_side_ = 0;
  double tag_size_ = 0;
  std::vector<Located> found_;
};

void AddArucos(bool refine, Systems* systems) {
  for (const int bits : {4, 5, 6}) {
    const std::string size = std::to_string(bits);
    std::unique_ptr<Peer> peer = MakeAruco(bits, refine);
    if (!peer) return;
    systems->push_back(std::make_unique<PeerSystem>(
        "ArUco " + size + "x" + size + (refine ? " subpix" : ""), std::move(peer), false));
  }
}

}  // namespace

Systems MakePeerSystems() {
  Systems systems;
  for (const AprilTagFamily family :
       {AprilTagFamily::k36h11, AprilTagFamily::k25h9, AprilTagFamily::k16h5}) {
    std::unique_ptr<Peer> peer = MakeAprilTag(family);
    if (!peer) break;
    const std::string name = "AprilTag " + peer->dictionary();
    systems.push_back(std::make_unique<PeerSystem>(name, std::move(peer), true));
  }
  AddArucos(false, &systems);
  return systems;
}

Systems MakeRefinedPeerSystems() {
  Systems systems;
  AddArucos(true, &systems);
  return systems;
}

}  // namespace topotag::bench::paper
