#include "host/object_system.h"

#include <cmath>

#include "host/cholesky.h"
#include "host/planar_pose.h"
#include "host/vertices.h"

namespace topotag {
namespace {

constexpr double kMinDepth = 1e-9;  // metres

// Derivatives of one image coordinate of a vertex by N unknowns, then its error.
template <std::size_t N>
using Row = std::array<double, N + 1>;

// Adds weight * (row' row).
template <std::size_t N>
void AddRow(const Row<N>& row, double weight, NormalEquations<N>* equations) {
  for (std::size_t i = 0; i < N; ++i) {
    const double value = weight * row[i];
    for (std::size_t k = 0; k <= i; ++k) equations->matrix[i][k] += value * row[k];
    equations->gradient[i] += value * row[N];
  }
  equations->cost += weight * row[N] * row[N];
}

// Weighted moments of a marker's vertices about its centre.
struct Moments {
  double one, x, y, xx, xy, yy;
};

// The rows of one image coordinate, summed with the weights 1, x and y: what an offset and a strain
// of the marker take up of it.
template <std::size_t N>
struct Taken {
  std::array<Row<N>, 3> sums{};

  void Add(const Row<N>& row, double weight, double x, double y) {
    for (std::size_t i = 0; i <= N; ++i) {
      const double value = weight * row[i];
      sums[0][i] += value;
      sums[1][i] += x * value;
      sums[2][i] += y * value;
    }
  }
  // By the decomposition L D L' of the moments: three squares.
  void Eliminate(const Moments& m, NormalEquations<N>* equations) {
    const double lx = m.x / m.one, ly = m.y / m.one;
    const double dx = m.xx - lx * m.x;
    const double lxy = (m.xy - lx * m.y) / dx;
    const double dy = m.yy - ly * m.y - lxy * (m.xy - lx * m.y);
    for (std::size_t i = 0; i <= N; ++i) {
      sums[1][i] -= lx * sums[0][i];
      sums[2][i] -= ly * sums[0][i] + lxy * sums[1][i];
    }
    AddRow<N>(sums[0], -1 / m.one, equations);
    AddRow<N>(sums[1], -1 / dx, equations);
    AddRow<N>(sums[2], -1 / dy, equations);
  }
};

// A vertex in the camera, and the derivatives of its pixel by its place there.
struct Projected {
  Point2 pixel;
  std::array<Vector3, 2> by_place;
};

bool ProjectPlace(const Camera& camera, const Vector3& place, Projected* projected) {
  if (!(place[2] > kMinDepth)) return false;
  const double iz = 1 / place[2];
  const Point2 q{place[0] * iz, place[1] * iz};
  Jacobian2 j;
  projected->pixel = Project(camera, q, &j);
  for (std::size_t c = 0; c < 2; ++c) {
    const double gx = j[2 * c] * iz, gy = j[2 * c + 1] * iz;
    projected->by_place[c] = {gx, gy, -(gx * q.x + gy * q.y)};
  }
  return true;
}

// g (w x arm + dt) as a row by (w, dt).
void SetMotion(const Vector3& arm, const Vector3& g, double* row) {
  const Vector3 turned = Cross(arm, g);
  for (std::size_t i = 0; i < 3; ++i) {
    row[i] = turned[i];
    row[i + 3] = g[i];
  }
}

Point2 Centre(const VertexList& pixels) {
  Point2 sum;
  for (const Point2& p : pixels) {
    sum.x += p.x;
    sum.y += p.y;
  }
  return {sum.x / pixels.size(), sum.y / pixels.size()};
}

Vector3 OnTag(const MarkerVertices& vertices, int i) {
  return {vertices.model[i].x * vertices.unit, vertices.model[i].y * vertices.unit, 0};
}

template <std::size_t N>
NormalEquations<N> Evaluate(const Camera& camera, const RigidTransform& view,
                            const RigidTransform& marker, const MarkerVertices& vertices) {
  NormalEquations<N> equations;
  const VertexList& pixels = *vertices.pixels;
  const Point2 centre = Centre(pixels);
  const Matrix3 to_object = Transposed(view.R);
  Taken<N> taken[2];
  Moments m{vertices.offset_ratio, 0, 0, vertices.strain_ratio, 0, vertices.strain_ratio};
  for (int i = 0; i < pixels.size(); ++i) {
    const Vector3 on_marker = marker.R * OnTag(vertices, i);  // from the marker's origin
    const Vector3 rotated = view.R * (on_marker + marker.t);  // from the object's origin
    Projected projected;
    if (!ProjectPlace(camera, rotated + view.t, &projected)) {
      equations.cost = INFINITY;
      return equations;
    }
    const double error[2] = {projected.pixel.x - pixels[i].x, projected.pixel.y - pixels[i].y};
    const double weight = i < 2 ? kBaselineWeight : 1;
    const double x = pixels[i].x - centre.x, y = pixels[i].y - centre.y;
    for (std::size_t c = 0; c < 2; ++c) {
      Row<N> row;
      SetMotion(rotated, projected.by_place[c], row.data());
      if (N == 12) SetMotion(on_marker, to_object * projected.by_place[c], row.data() + N - 6);
      row[N] = error[c];
      AddRow<N>(row, weight, &equations);
      taken[c].Add(row, weight, x, y);
    }
    m.one += weight;
    m.x += weight * x;
    m.y += weight * y;
    m.xx += weight * x * x;
    m.xy += weight * x * y;
    m.yy += weight * y * y;
  }
  for (Taken<N>& coordinate : taken) coordinate.Eliminate(m, &equations);
  return equations;
}

}  // namespace

PoseEquations EvaluateView(const Camera& camera, const RigidTransform& view,
                           const RigidTransform& marker, const MarkerVertices& vertices) {
  return Evaluate<6>(camera, view, marker, vertices);
}

MarkerEquations EvaluateMarker(const Camera& camera, const RigidTransform& view,
                               const RigidTransform& marker, const MarkerVertices& vertices) {
  return Evaluate<12>(camera, view, marker, vertices);
}

double ReprojectionSquares(const Camera& camera, const RigidTransform& pose,
                           const MarkerVertices& vertices) {
  double squares = 0;
  for (int i = 0; i < vertices.pixels->size(); ++i) {
    Projected projected;
    if (!ProjectPlace(camera, pose * OnTag(vertices, i), &projected)) return INFINITY;
    const double ex = projected.pixel.x - (*vertices.pixels)[i].x;
    const double ey = projected.pixel.y - (*vertices.pixels)[i].y;
    squares += ex * ex + ey * ey;
  }
  return squares;
}

bool SolvePose(const PoseEquations& equations, double damping, Vector6* step) {
  Matrix6 factor = equations.matrix;
  for (std::size_t i = 0; i < 6; ++i) {
    factor[i][i] *= 1 + damping;
    (*step)[i] = -equations.gradient[i];
  }
  if (!Factorize(factor[0].data(), 6)) return false;
  SolveFactorized(factor[0].data(), 6, step->data());
  return true;
}

RigidTransform Moved(const RigidTransform& pose, const double* step) {
  return {SmallRotation({step[0], step[1], step[2]}) * pose.R,
          pose.t + Vector3{step[3], step[4], step[5]}};
}

}  // namespace topotag
