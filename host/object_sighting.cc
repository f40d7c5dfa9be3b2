#include "host/object_sighting.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/cholesky.h"
#include "host/homography.h"
#include "host/model.h"
#include "host/planar_pose.h"
#include "host/pose.h"

namespace topotag {
namespace {

// A detection's pose and that from its vertices differ by less than this part of the distance.
constexpr double kSameSize = 0.1;
// Least standard deviation of the noise of one vertex coordinate, pixels.
constexpr double kFloorSigma = 0.005;

// Systematic errors of the vertices of one marker, by the length of a unit in the direction of
// steepest foreshortening: measured on renders without noise, with a blur of 0.7 to 1 px.
double OffsetSigma(double unit) { return 0.06 * std::exp(-unit) + 2e-3; }  // pixels
double StrainSigma(double unit) { return 0.02 * std::exp(-1.6 * unit) + 2e-5; }

// Corners of the grid of vertices, as p1, then along +x.
std::array<Point2, 4> GridCorners(Family family, const VertexList& vertices) {
  const int n = family.n();
  return {vertices[0], vertices[n - 1], vertices[n * n - 1], vertices[n * (n - 1)]};
}

// Tag units to ideal pixels.
bool FitVertices(Family family, const VertexList& vertices, const Camera& camera,
                 Homography* homography) {
  VertexList ideal;
  ideal.resize(vertices.size());
  for (int i = 0; i < vertices.size(); ++i) {
    if (!PixelToIdeal(&camera, vertices[i], &ideal[i])) return false;
  }
  const Point2* model = ModelTable(family);
  Homography guess;
  return SquareToQuad(-model[0].x, GridCorners(family, ideal).data(), &guess) &&
         FitHomography(model, ideal.begin(), ideal.size(), guess, homography);
}

// Length of a unit in the direction of steepest foreshortening, pixels.
double ShortestUnit(const Homography& map) {
  Jacobian2 j;
  map.Map({0, 0}, &j);
  const double squares = j[0] * j[0] + j[1] * j[1] + j[2] * j[2] + j[3] * j[3];
  const double det = j[0] * j[3] - j[1] * j[2];
  const double spread = std::sqrt(std::max(squares * squares - 4 * det * det, 0.0));
  return std::abs(det) / std::sqrt((squares + spread) / 2);
}

// Derivatives of the motion of a point with this arm, the rotation first, by (w, dt).
Matrix6 MotionOf(const Vector3& arm) {
  Matrix6 m{};
  for (size_t i = 0; i < 6; ++i) m[i][i] = 1;
  m[3][1] = arm[2];
  m[3][2] = -arm[1];
  m[4][0] = -arm[2];
  m[4][2] = arm[0];
  m[5][0] = arm[1];
  m[5][1] = -arm[0];
  return m;
}

// From a measured to a predicted pose: rotation vector, translation.
Vector6 PoseError(const RigidTransform& measured, const RigidTransform& predicted) {
  const Vector3 w = RotationVector(predicted.R * Transposed(measured.R));
  const Vector3 dt = predicted.t - measured.t;
  return {w[0], w[1], w[2], dt[0], dt[1], dt[2]};
}

template <size_t N>
void AddError(const std::array<std::array<double, N>, 6>& jacobian, const Matrix6& information,
              const Vector6& error, NormalEquations<N>* equations) {
  for (size_t i = 0; i < 6; ++i) {
    Vector6 row = information[i];
    double weighted = 0;
    for (size_t k = 0; k < 6; ++k) weighted += row[k] * error[k];
    equations->cost += error[i] * weighted;
    std::array<double, N> product{};
    for (size_t k = 0; k < 6; ++k) {
      for (size_t m = 0; m < N; ++m) product[m] += row[k] * jacobian[k][m];
    }
    for (size_t n = 0; n < N; ++n) {
      equations->gradient[n] += jacobian[i][n] * weighted;
      for (size_t m = 0; m <= n; ++m) equations->matrix[n][m] += jacobian[i][n] * product[m];
    }
  }
}

// Whether the vertices say less than the pose does, or are not measured one by one.
bool IsKnownByPose(const Detection& detection) {
  const bool is_photometric =
      detection.pose && detection.pose->photometric && detection.pose->photometric->accepted;
  return is_photometric || detection.margin || detection.unknown_bits != 0;
}

// Makes the sighting one by the detection's pose.
// @return false where there is none, or that of another size
bool TakePose(const Detection& detection, Sighting* sighting) {
  if (!detection.pose) return false;
  const Pose& pose = *detection.pose;
  if (!IsFinite(pose) || (pose.alternative && !IsFinite(*pose.alternative))) return false;
  const Vector3 moved = pose.t - sighting->poses[0].t;
  if (!(Dot(moved, moved) < kSameSize * kSameSize * Dot(pose.t, pose.t))) return false;
  Matrix6 factor = pose.covariance;
  if (!InvertPositive(factor[0].data(), 6, sighting->information[0].data())) return false;
  sighting->by_pose = true;
  sighting->poses[0] = {pose.R, pose.t};
  sighting->pose_count = pose.alternative ? 2 : 1;
  if (pose.alternative) sighting->poses[1] = {pose.alternative->R, pose.alternative->t};
  return true;
}

}  // namespace

ObjectIndex::ObjectIndex(const Object& object) {
  for (size_t i = 0; i < object.markers.size(); ++i) {
    const ObjectMarker& marker = object.markers[i];
    markers_[{marker.family.n(), marker.id}] = static_cast<int>(i);
  }
}

int ObjectIndex::Find(Family family, uint64_t id) const {
  const auto found = markers_.find({family.n(), id});
  return found == markers_.end() ? -1 : found->second;
}

PoseEquations Sighting::ByView(const Camera& camera, const RigidTransform& view,
                               const RigidTransform& on_object) const {
  PoseEquations equations;
  if (by_pose) {
    const Matrix6 error_by_view = MotionOf(view.R * on_object.t);
    AddError(error_by_view, information, PoseError(poses[0], view * on_object), &equations);
  } else {
    equations.Add(EvaluateView(camera, view, on_object, vertices), weight);
  }
  return equations;
}

MarkerEquations Sighting::ByMarker(const Camera& camera, const RigidTransform& view,
                                   const RigidTransform& on_object) const {
  MarkerEquations equations;
  if (!by_pose) {
    equations.Add(EvaluateMarker(camera, view, on_object, vertices), weight);
    return equations;
  }
  const Matrix6 by_view = MotionOf(view.R * on_object.t);
  std::array<std::array<double, 12>, 6> jacobian{};
  for (size_t i = 0; i < 6; ++i) {
    for (size_t k = 0; k < 6; ++k) jacobian[i][k] = by_view[i][k];
  }
  for (size_t i = 0; i < 3; ++i) {
    for (size_t k = 0; k < 3; ++k) jacobian[i][k + 6] = jacobian[i + 3][k + 9] = view.R[i][k];
  }
  AddError(jacobian, information, PoseError(poses[0], view * on_object), &equations);
  return equations;
}

bool MakeSighting(const Detection& detection, const Camera& camera, double tag_size,
                  Sighting* sighting) {
  const Family family = detection.family;
  Homography map;
  Pose pose;
  if (detection.vertices.size() != family.vertex_count() ||
      !FitVertices(family, detection.vertices, camera, &map) ||
      !EstimatePose(family, detection.vertices, map, camera, tag_size, &pose)) {
    return false;
  }
  const std::array<Point2, 4> corners = GridCorners(family, detection.vertices);
  sighting->side = 0;
  for (size_t i = 0; i < 4; ++i) {
    const Point2 &a = corners[i], &b = corners[(i + 1) % 4];
    sighting->side += std::hypot(a.x - b.x, a.y - b.y) / 4;
  }
  // rms_px is that of both coordinates together, less what the 6 parameters have taken up.
  const int count = family.vertex_count();
  const double variance = pose.rms_px * pose.rms_px * count / (2 * count - 6);
  const double noise = std::max(variance, kFloorSigma * kFloorSigma);
  const double length = ShortestUnit(map);
  const double offset = OffsetSigma(length), strain = StrainSigma(length);
  sighting->weight = 1 / noise;
  sighting->vertices = {ModelTable(family), tag_size / family.white_side(), &detection.vertices,
                        noise / (offset * offset), noise / (strain * strain)};
  sighting->pose_count = pose.alternative ? 2 : 1;
  sighting->poses[0] = {pose.R, pose.t};
  if (pose.alternative) sighting->poses[1] = {pose.alternative->R, pose.alternative->t};
  return !IsKnownByPose(detection) || TakePose(detection, sighting);
}

}  // namespace topotag
