#ifndef TOPOTAG_HOST_OBJECT_SYSTEM_H_
#define TOPOTAG_HOST_OBJECT_SYSTEM_H_

#include <cstddef>

#include "host/rigid_transform.h"
#include "topotag/camera.h"
#include "topotag/detection.h"

namespace topotag {

/// Normal equations of N unknowns: half the sum of squares is cost / 2 + gradient' x + x' matrix x
/// / 2.
template <std::size_t N>
struct NormalEquations {
  double cost = 0;
  std::array<std::array<double, N>, N> matrix{};  ///< lower triangle
  std::array<double, N> gradient{};

  void Add(const NormalEquations& other, double weight) {
    cost += weight * other.cost;
    for (std::size_t i = 0; i < N; ++i) {
      gradient[i] += weight * other.gradient[i];
      for (std::size_t k = 0; k <= i; ++k) matrix[i][k] += weight * other.matrix[i][k];
    }
  }
};

/// A pose's unknowns are (w, dt): R' = exp(w) R, t' = t + dt. Those of a marker on an object in a
/// view are the view's, then the marker's.
using PoseEquations = NormalEquations<6>;
using MarkerEquations = NormalEquations<12>;
using Vector6 = std::array<double, 6>;

/// The vertices of one marker that one frame shows.
///
/// Their errors are white noise and, common to all vertices of the marker, an offset and a strain
/// (an affine map about the marker's centre) that are known to be small only: what blur and
/// neighbouring nodes do to centroids. The equations have both eliminated. p1 and p2 count half, as
/// they are measured together.
struct MarkerVertices {
  const Point2* model;       ///< units of the tag
  double unit;               ///< metres
  const VertexList* pixels;  ///< as many
  /// Variance of the noise over that of the offset (1) and of the strain (pixels^2).
  double offset_ratio;
  double strain_ratio;
};

/// The equations of the errors in pixels by `view`, x_camera = view * marker * x_tag; cost infinite
/// with a vertex behind the camera.
PoseEquations EvaluateView(const Camera& camera, const RigidTransform& view,
                           const RigidTransform& marker, const MarkerVertices& vertices);

/// The same by `view` and `marker`.
MarkerEquations EvaluateMarker(const Camera& camera, const RigidTransform& view,
                               const RigidTransform& marker, const MarkerVertices& vertices);

/// Sum of the squared errors as they are, pixels^2; infinite with a vertex behind the camera.
double ReprojectionSquares(const Camera& camera, const RigidTransform& pose,
                           const MarkerVertices& vertices);

/// The step of the equations with their diagonal grown by the part `damping`.
/// @return false where they do not determine it.
bool SolvePose(const PoseEquations& equations, double damping, Vector6* step);

/// The pose after a step.
RigidTransform Moved(const RigidTransform& pose, const double* step);

}  // namespace topotag

#endif  // TOPOTAG_HOST_OBJECT_SYSTEM_H_
