#include "bench/accuracy_cells.h"

#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "bench/corner_pose.h"
#include "host/cholesky.h"
#include "host/rigid_transform.h"
#include "tests/scene_util.h"

namespace topotag::bench {
namespace {

constexpr std::array<PoseMode, 2> kOurs{PoseMode::kPhotometric, PoseMode::kVertices};
constexpr std::array<const char*, 3> kSolvers{"own", "IPPE", "IPPE+LM"};

Options ModeOptions(Options options, PoseMode mode, const Scene& scene) {
  options.threads = 1;
  options.families = {scene.markers[0].design.family};
  options.camera = scene.camera;
  options.tag_size = scene.markers[0].tag_size;
  options.pose = mode;
  return options;
}

PoseError ErrorOf(const PoseSolution& pose, const SceneMarker& truth) {
  PoseError error;
  error.position = test::Distance(pose.t, truth.t);
  error.rotation = test::AngleBetween(pose.R, truth.R) * test::kDegree;
  return error;
}

double SquaredMahalanobis(const Pose& pose, const SceneMarker& truth) {
  const Vector3 w = RotationVector(truth.R * Transposed(pose.R));
  std::array<double, 6> solved{};
  for (size_t i = 0; i < 3; ++i) {
    solved[i] = w[i];
    solved[i + 3] = truth.t[i] - pose.t[i];
  }
  const std::array<double, 6> error = solved;
  Matrix6 factor = pose.covariance;
  if (!Factorize(factor[0].data(), 6)) return INFINITY;
  SolveFactorized(factor[0].data(), 6, solved.data());
  return std::inner_product(error.begin(), error.end(), solved.begin(), 0.0);
}

}  // namespace

AccuracyBench::AccuracyBench(bool aruco, const Options& options) : options_(options) {
  for (const PoseMode mode : kOurs) empty_.push_back({Name(mode), true, {}});
  if (std::unique_ptr<Peer> peer = MakeAprilTag()) peers_.push_back(std::move(peer));
  if (aruco) {
    for (auto& peer : MakeRefinedAruco()) peers_.push_back(std::move(peer));
  }
  for (const auto& peer : peers_) {
    for (const char* solver : kSolvers) empty_.push_back({peer->name() + " " + solver, false, {}});
  }
}

AccuracyCell AccuracyBench::Measure(const View& view, int frames, uint64_t seed) {
  AccuracyCell cell = Empty(view);
  for (int frame = 0; frame < frames; ++frame) {
    const Scene scene = MakeView(view, seed + static_cast<uint64_t>(frame));
    cell.bounds.push_back(CramerRaoBound(scene));
    MeasureFrame(scene, &cell);
  }
  return cell;
}

void AccuracyBench::MeasureFrame(const Scene& scene, AccuracyCell* cell) {
  MeasureOurs(scene, cell);
  size_t system = kOurs.size();
  for (const auto& peer : peers_) MeasurePeer(scene, peer.get(), &system, cell);
}

void AccuracyBench::MeasureOurs(const Scene& scene, AccuracyCell* cell) {
  const Image frame = RenderScene(scene);
  const SceneMarker& truth = scene.markers[0];
  for (size_t mode = 0; mode < kOurs.size(); ++mode) {
    std::optional<PoseError> error;
    for (const Detection& found :
         Detector(ModeOptions(options_, kOurs[mode], scene)).detect(frame.view())) {
      if (found.id != truth.design.id || !found.pose) continue;
      error = ErrorOf(*found.pose, truth);
      error->mahalanobis2 = SquaredMahalanobis(*found.pose, truth);
    }
    cell->systems[mode].frames.push_back(error);
  }
}

void AccuracyBench::MeasurePeer(const Scene& scene, Peer* peer, size_t* system,
                                AccuracyCell* cell) {
  const SceneMarker& truth = scene.markers[0];
  const int id = static_cast<int>(scene.seed % 200);
  const Image frame = RenderBitmaps(scene, {peer->Marker(id)});
  const double side = kViewSide * peer->black_share();
  std::vector<Located> markers;
  peer->Locate(frame.view(), &markers);
  std::array<std::optional<PoseSolution>, kSolvers.size()> poses;
  for (size_t i = 0; i < markers.size(); ++i) {
    if (markers[i].id != id) continue;
    poses = {peer->OwnPose(i, scene.camera, side),
             PoseOfCorners(markers[i].corners, side, scene.camera, false),
             PoseOfCorners(markers[i].corners, side, scene.camera, true)};
  }
  for (const auto& pose : poses) {
    std::optional<PoseError> error;
    if (pose) error = ErrorOf(*pose, truth);
    cell->systems[(*system)++].frames.push_back(error);
  }
}

}  // namespace topotag::bench
