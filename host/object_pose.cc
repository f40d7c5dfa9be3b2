// One pose from all visible markers of an object: consensus over the markers' own poses, then
// robust Levenberg-Marquardt on all vertices.
#include <algorithm>
#include <cmath>

#include "host/check.h"
#include "host/cholesky.h"
#include "host/object_sighting.h"
#include "host/one_thread.h"
#include "topotag/object.h"

namespace topotag {
namespace {

// Hypotheses come from this many markers, the largest in the frame.
constexpr size_t kMaxSources = 16;
constexpr int kMaxIterations = 20;
constexpr int kMaxRounds = 6;
// A pose is done where the next step would improve the weighted error's norm by less than this, in
// standard deviations of one vertex coordinate.
constexpr double kStop = 1e-3;
// A marker agrees with a pose that puts it within this part of its side, or this many pixels.
constexpr double kGateSide = 0.25;
constexpr double kGatePixels = 3;
// A marker contradicts the others where its error is this many times their median error, and as
// many standard deviations.
constexpr double kOutlierRatio = 4;
constexpr double kSameRotation = 2e-3;     // rad: poses this close are one
constexpr double kOtherHypothesis = 0.03;  // rad: what may lead to another pose

struct Seen : Sighting {
  RigidTransform on_object;
  double gate = 0;  ///< pixels
  bool used = false;
  PoseEquations equations;  ///< at the pose evaluated last

  /// Mean square error in standard deviations.
  double Excess() const { return equations.cost / Freedom(); }
  bool IsNear(const Camera& camera, const RigidTransform& pose) const {
    return MeanSquare(camera, pose * on_object) < gate * gate;
  }
};

struct Hypothesis {
  RigidTransform pose;
  double score;  ///< the smaller, the more markers agree
};

// Cauchy's kernel over whole markers, by the mean square of a marker's errors.
struct Kernel {
  double squared_scale = INFINITY;  ///< infinite: least squares

  double Rho(double excess) const {
    if (squared_scale == INFINITY || excess == INFINITY) return excess;
    return squared_scale * std::log1p(excess / squared_scale);
  }
  double Weight(double excess) const { return 1 / (1 + excess / squared_scale); }
};

}  // namespace

struct ObjectPoseEstimator::Impl {
  Impl(const Object& given, const Camera& lens) : object(given), camera(lens), index(given) {}

  void Collect(const std::vector<Detection>& detections);
  void Suppose();
  bool Settle(RigidTransform* pose);
  bool Report(const RigidTransform& pose, ObjectPose* result);
  void FindAlternative(ObjectPose* result);

  OneThread one_thread;
  const Object object;
  const Camera camera;
  const ObjectIndex index;
  std::vector<Seen> seen;  ///< of the frame, the largest first
  std::vector<Hypothesis> hypotheses;
  std::vector<double> excesses;

 private:
  double Score(const RigidTransform& pose) const;
  void EvaluateAll(const RigidTransform& pose);
  bool AllNear(const RigidTransform& pose) const;
  double Rms(const RigidTransform& pose) const;
  PoseEquations Evaluate(const RigidTransform& pose, const Kernel& kernel);
  bool Refine(const Kernel& kernel, RigidTransform* pose);
  double MedianExcess();
};

void ObjectPoseEstimator::Impl::Collect(const std::vector<Detection>& detections) {
  seen.clear();
  for (size_t i = 0; i < detections.size(); ++i) {
    const Detection& detection = detections[i];
    Seen one;
    one.detection = static_cast<int>(i);
    one.marker = index.Find(detection.family, detection.id);
    if (one.marker < 0) continue;
    const ObjectMarker& marker = object.markers[static_cast<size_t>(one.marker)];
    if (!MakeSighting(detection, camera, marker.tag_size, &one)) continue;
    one.on_object = {marker.R, marker.t};
    one.gate = std::max(kGatePixels, kGateSide * one.side);
    seen.push_back(one);
  }
  // Stable order whatever the order of the detections.
  std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) {
    return a.side != b.side ? a.side > b.side : a.detection < b.detection;
  });
}

// Each marker counts for at most 1, the less the better it agrees.
double ObjectPoseEstimator::Impl::Score(const RigidTransform& pose) const {
  double score = 0;
  for (const Seen& one : seen) {
    const double squares = one.MeanSquare(camera, pose * one.on_object);
    score += squares == INFINITY ? 1 : squares / (squares + one.gate * one.gate);
  }
  return score;
}

void ObjectPoseEstimator::Impl::Suppose() {
  hypotheses.clear();
  for (size_t i = 0; i < std::min(seen.size(), kMaxSources); ++i) {
    const RigidTransform to_tag = seen[i].on_object.Inverse();
    for (int k = 0; k < seen[i].pose_count; ++k) {
      const RigidTransform pose = seen[i].poses[k] * to_tag;
      hypotheses.push_back({pose, Score(pose)});
    }
  }
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.score < b.score; });
}

void ObjectPoseEstimator::Impl::EvaluateAll(const RigidTransform& pose) {
  for (Seen& one : seen) one.equations = one.ByView(camera, pose, one.on_object);
}

// Whether every marker in use is where the pose puts it.
bool ObjectPoseEstimator::Impl::AllNear(const RigidTransform& pose) const {
  return std::all_of(seen.begin(), seen.end(),
                     [&](const Seen& one) { return !one.used || one.IsNear(camera, pose); });
}

// Root mean square reprojection error of the vertices in use, pixels.
double ObjectPoseEstimator::Impl::Rms(const RigidTransform& pose) const {
  double squares = 0;
  int count = 0;
  for (const Seen& one : seen) {
    if (!one.used) continue;
    squares += ReprojectionSquares(camera, pose * one.on_object, one.vertices);
    count += one.vertices.pixels->size();
  }
  return std::sqrt(squares / count);
}

// The equations of the markers in use.
PoseEquations ObjectPoseEstimator::Impl::Evaluate(const RigidTransform& pose,
                                                  const Kernel& kernel) {
  PoseEquations total;
  double cost = 0;
  for (Seen& one : seen) {
    if (!one.used) continue;
    one.equations = one.ByView(camera, pose, one.on_object);
    const double excess = one.Excess();
    cost += kernel.Rho(excess) * one.Freedom();
    total.Add(one.equations, kernel.Weight(excess));
  }
  total.cost = cost;
  return total;
}

// @return false where the markers in use do not determine the pose.
bool ObjectPoseEstimator::Impl::Refine(const Kernel& kernel, RigidTransform* pose) {
  double damping = 1e-6;
  PoseEquations system = Evaluate(*pose, kernel);
  for (int i = 0; i < kMaxIterations && std::isfinite(system.cost); ++i) {
    Vector6 step;
    if (!SolvePose(system, damping, &step)) return false;
    double gain = 0;
    for (size_t k = 0; k < 6; ++k) gain -= system.gradient[k] * step[k];
    if (!(gain > kStop * kStop)) break;
    const RigidTransform next = Moved(*pose, step.data());
    const PoseEquations moved = Evaluate(next, kernel);
    if (moved.cost < system.cost) {
      *pose = next;
      system = moved;
      damping /= 10;
    } else {
      damping = std::max(damping * 10, 1e-3);
    }
  }
  pose->R = Orthonormalized(pose->R);
  return std::isfinite(system.cost);
}

// Of the markers in use.
double ObjectPoseEstimator::Impl::MedianExcess() {
  excesses.clear();
  for (const Seen& one : seen) {
    if (one.used) excesses.push_back(one.Excess());
  }
  if (excesses.empty()) return 0;
  const auto middle = excesses.begin() + static_cast<std::ptrdiff_t>((excesses.size() - 1) / 2);
  std::nth_element(excesses.begin(), middle, excesses.end());
  return *middle;
}

// From a hypothesis to the least-squares pose of the markers that agree on it.
bool ObjectPoseEstimator::Impl::Settle(RigidTransform* pose) {
  EvaluateAll(*pose);
  for (Seen& one : seen) one.used = one.IsNear(camera, *pose);
  for (int round = 0; round < kMaxRounds; ++round) {
    const double scale = kOutlierRatio * kOutlierRatio * std::max(MedianExcess(), 1.0);
    if (!Refine({scale}, pose)) return false;
    EvaluateAll(*pose);
    const double limit = kOutlierRatio * kOutlierRatio * std::max(MedianExcess(), 1.0);
    bool changed = false;
    for (Seen& one : seen) {
      const bool agrees = one.IsNear(camera, *pose) && one.Excess() <= limit;
      changed |= agrees != one.used;
      one.used = agrees;
    }
    if (!changed && round > 0) break;
  }
  return Refine({}, pose);
}

// The pose, its covariance and what it rests on.
bool ObjectPoseEstimator::Impl::Report(const RigidTransform& pose, ObjectPose* result) {
  const PoseEquations total = Evaluate(pose, {});
  Matrix6 factor = total.matrix;
  Matrix6 inverse;
  if (!InvertPositive(factor[0].data(), 6, inverse[0].data())) return false;
  result->R = pose.R;
  result->t = pose.t;
  result->rms_px = Rms(pose);
  result->used.clear();
  result->rejected.clear();
  int freedom = -6;
  for (const Seen& one : seen) {
    (one.used ? result->used : result->rejected).push_back(one.detection);
    freedom += one.used ? one.Freedom() : 0;
  }
  std::sort(result->used.begin(), result->used.end());
  std::sort(result->rejected.begin(), result->rejected.end());
  // Errors are in standard deviations: where these are right, the cost is the degrees of freedom.
  const double scale = freedom > 0 ? std::max(total.cost / freedom, 1.0) : 1;
  for (size_t i = 0; i < 6; ++i) {
    for (size_t k = 0; k < 6; ++k) result->covariance[i][k] = scale * inverse[i][k];
  }
  return true;
}

// Another minimum in which every marker in use is still near: only nearly flat objects have one.
void ObjectPoseEstimator::Impl::FindAlternative(ObjectPose* result) {
  result->alternative.reset();
  for (const Hypothesis& hypothesis : hypotheses) {
    RigidTransform pose = hypothesis.pose;
    if (RotationBetween(pose.R, result->R) < kOtherHypothesis || !AllNear(pose)) continue;
    if (!Refine({}, &pose) || !AllNear(pose)) return;
    if (RotationBetween(pose.R, result->R) < kSameRotation) return;
    PoseSolution& other = result->alternative.emplace();
    other.R = pose.R;
    other.t = pose.t;
    other.rms_px = Rms(pose);
    return;
  }
}

ObjectPoseEstimator::ObjectPoseEstimator(const Object& object, const Camera& camera) {
  ValidateObject(object);
  ValidateCamera(camera);
  impl_ = std::make_unique<Impl>(object, camera);
}

ObjectPoseEstimator::~ObjectPoseEstimator() = default;
ObjectPoseEstimator::ObjectPoseEstimator(ObjectPoseEstimator&&) noexcept = default;
ObjectPoseEstimator& ObjectPoseEstimator::operator=(ObjectPoseEstimator&&) noexcept = default;

ObjectPoseEstimator::Impl& ObjectPoseEstimator::impl() const {
  if (impl_ == nullptr) FailArgument("the object's pose estimator has been moved from");
  return *impl_;
}

const Object& ObjectPoseEstimator::object() const { return impl().object; }

bool ObjectPoseEstimator::estimate(const std::vector<Detection>& detections, ObjectPose* pose) {
  RequireNotNull(pose, "pose");
  Impl& impl = this->impl();
  const OneThread::Use use(&impl.one_thread, "the object's pose estimator");
  impl.Collect(detections);
  impl.Suppose();
  for (const Hypothesis& hypothesis : impl.hypotheses) {
    RigidTransform found = hypothesis.pose;
    if (!impl.Settle(&found) || !impl.Report(found, pose)) continue;
    impl.FindAlternative(pose);
    return true;
  }
  return false;
}

}  // namespace topotag
