#include "host/photometric.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model.h"
#include "host/photometric_look.h"

namespace topotag {
namespace {

// The other planar solution is tried where its vertices fit worse by no more than this.
constexpr double kAmbiguous = 0.3;
// The image is not that of the marker where the residuals exceed the larger of these: times the
// noise between neighbours, and parts of the contrast.
constexpr double kMaxNoise = 5;
constexpr double kMaxSigma = 0.06;
constexpr double kTypicalBlur = 0.7 * 0.7 + 1.0 / 12;  // variance, square pixels
// Residuals of the right shape are below one of these: parts of the contrast, times the noise
// between neighbours.
constexpr double kGoodSigma = 0.015;
constexpr double kGoodNoise = 1.2;
constexpr double kMinContrast = 5;  // grey levels
constexpr double kMaxMissingHoles = 0.4;
constexpr double kMaxOutliers = 0.3;
// A pose is that of the vertices, better: vertices move by less than this.
constexpr double kMaxMove = 1;         // pixels
constexpr double kMaxMoveUnits = 0.3;  // units; the larger one counts

Rigid ToRigid(const PoseSolution& pose, double unit) {
  Rigid rigid;
  for (size_t r = 0; r < 3; ++r) {
    rigid.x[r] = pose.R[r][0];
    rigid.y[r] = pose.R[r][1];
    rigid.t[r] = pose.t[r] / unit;
  }
  return rigid;
}

double VertexRms(const Camera& camera, const Rigid& pose, const Detection& detection) {
  const Point2* model = ModelTable(detection.family);
  double sum = 0;
  for (int i = 0; i < detection.vertices.size(); ++i) {
    const Point2 p = ToPixel(camera, pose, model[i]);
    const double dx = p.x - detection.vertices[i].x, dy = p.y - detection.vertices[i].y;
    sum += dx * dx + dy * dy;
  }
  return std::sqrt(sum / detection.vertices.size());
}

class Refinement {
 public:
  Refinement(const ImageView& image, const Camera& camera, double unit,
             PhotometricWorkspace* workspace, Detection* detection)
      : image_(image),
        camera_(camera),
        unit_(unit),
        workspace_(*workspace),
        detection_(*detection) {}

  bool Run();

 private:
  PhotometricState StartState(const PoseSolution& start) const;
  bool Fit(const PoseSolution& start, InnerShape shape, PhotometricFit* fit);
  bool FitShapes(const PoseSolution& start, PhotometricFit* fit);
  bool IsAcceptable(const PoseSolution& start, const PhotometricFit& fit) const;
  PoseSolution ToSolution(const PhotometricFit& fit) const;
  void Report(const PhotometricFit& fit, bool accepted);

  const ImageView& image_;
  const Camera& camera_;
  const double unit_;
  PhotometricWorkspace& workspace_;
  Detection& detection_;
  double black_, white_;  // levels, about
  KnownOutline surroundings_;
  InnerShape shape_;
};

PhotometricState Refinement::StartState(const PoseSolution& start) const {
  PhotometricState state{};
  state.pose = ToRigid(start, unit_);
  state.black = black_;
  state.white = white_;
  state.background = 0.5 * (black_ + white_);
  state.blur = {kTypicalBlur, 0, kTypicalBlur};
  return state;
}

bool Refinement::Fit(const PoseSolution& start, InnerShape shape, PhotometricFit* fit) {
  const UnitPattern pattern(detection_.family, detection_.id, detection_.unknown_bits, shape,
                            surroundings_);
  return FitPhotometric(image_, pattern, camera_, StartState(start), &workspace_, fit) &&
         IsAcceptable(start, *fit);
}

// The shape that the marker looks like, unless much is left; then the best of all.
bool Refinement::FitShapes(const PoseSolution& start, PhotometricFit* fit) {
  bool accepted = Fit(start, shape_, fit);
  const double contrast = fit->state.white - fit->state.black;
  if (accepted && fit->sigma < std::max(kGoodSigma * contrast, kGoodNoise * fit->noise))
    return true;
  // What fits worse than a fit that is not accepted is none, either.
  double least = fit->converged ? fit->cost : INFINITY;
  InnerShape best = shape_;
  for (const InnerShape shape : {InnerShape::kSquare, InnerShape::kCircle, InnerShape::kHexagon}) {
    PhotometricFit other{};
    if (shape == shape_ || !Fit(start, shape, &other) || other.cost >= least) continue;
    *fit = other;
    least = other.cost;
    best = shape;
    accepted = true;
  }
  shape_ = best;
  return accepted;
}

bool Refinement::IsAcceptable(const PoseSolution& start, const PhotometricFit& fit) const {
  const double contrast = fit.state.white - fit.state.black;
  if (!fit.converged || !(contrast > kMinContrast) || fit.outliers > kMaxOutliers ||
      fit.missing_holes > kMaxMissingHoles) {
    return false;
  }
  if (!(fit.sigma < std::max(kMaxNoise * fit.noise, kMaxSigma * contrast))) return false;
  const Rigid before = ToRigid(start, unit_);
  const double limit =
      std::max(kMaxMove, kMaxMoveUnits * UnitPixels(camera_, before, detection_.family));
  const Point2* model = ModelTable(detection_.family);
  for (int i = 0; i < detection_.family.vertex_count(); ++i) {
    const Point2 p = ToPixel(camera_, before, model[i]);
    const Point2 q = ToPixel(camera_, fit.state.pose, model[i]);
    if (!(std::hypot(p.x - q.x, p.y - q.y) < limit)) return false;
  }
  return true;
}

PoseSolution Refinement::ToSolution(const PhotometricFit& fit) const {
  const Rigid& pose = fit.state.pose;
  const Vector3 z = Cross(pose.x, pose.y);
  PoseSolution solution;
  for (size_t r = 0; r < 3; ++r) solution.R[r] = {pose.x[r], pose.y[r], z[r]};
  solution.t = Scaled(pose.t, unit_);
  solution.rms_px = VertexRms(camera_, pose, detection_);
  return solution;
}

void Refinement::Report(const PhotometricFit& fit, bool accepted) {
  Photometric& report = detection_.pose->photometric.emplace();
  report.accepted = accepted;
  report.sigma = fit.sigma;
  report.noise = fit.noise;
  report.blur_px = std::sqrt(std::max(
      std::sqrt(std::max(
          fit.state.blur[0] * fit.state.blur[2] - fit.state.blur[1] * fit.state.blur[1], 0.0)) -
          1.0 / 12,
      0.0));
  report.black = fit.state.black;
  report.white = fit.state.white;
  report.growth = fit.state.growth;
  report.pixels = fit.pixels;
}

bool Refinement::Run() {
  Pose& pose = *detection_.pose;
  const Rigid start = ToRigid(pose, unit_);
  const MarkerLook look(image_, camera_, start, detection_.family);
  black_ = look.black();
  white_ = look.white();
  surroundings_ = look.FindOutline();
  shape_ = look.FindShape();
  PhotometricFit fit{};
  bool accepted = white_ - black_ > kMinContrast && FitShapes(pose, &fit);
  if (pose.alternative && pose.ambiguity > kAmbiguous) {
    PhotometricFit other;
    if (Fit(*pose.alternative, shape_, &other)) {
      if (!accepted || other.cost < fit.cost) {
        const PoseSolution loser = accepted ? ToSolution(fit) : static_cast<PoseSolution&>(pose);
        static_cast<PoseSolution&>(pose) = *pose.alternative;
        pose.alternative = loser;
        fit = other;
      } else {
        pose.alternative = ToSolution(other);
      }
      accepted = true;
    }
  }
  Report(fit, accepted);
  if (!accepted) return false;
  static_cast<PoseSolution&>(pose) = ToSolution(fit);
  for (size_t r = 0; r < 6; ++r) {
    for (size_t c = 0; c < 6; ++c) {
      const double lengths = (r < 3 ? 1 : unit_) * (c < 3 ? 1 : unit_);
      pose.covariance[r][c] = fit.covariance[r][c] * lengths;
    }
  }
  return true;
}

}  // namespace

bool RefinePhotometric(const ImageView& image, const Camera& camera, double tag_size,
                       PhotometricWorkspace* workspace, Detection* detection) {
  const double unit = tag_size / detection->family.white_side();
  return Refinement(image, camera, unit, workspace, detection).Run();
}

}  // namespace topotag
