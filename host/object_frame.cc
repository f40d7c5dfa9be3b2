#include "host/object_frame.h"

#include <array>

#include "host/cholesky.h"
#include "host/planar_pose.h"

namespace topotag {
namespace {

constexpr int kIterations = 30;

// The corners of a marker's white area, relative to its centre, object's axes.
std::array<Vector3, 4> Arms(const ObjectMarker& marker) {
  const double half = marker.tag_size / 2;
  return {marker.R * Vector3{-half, -half, 0}, marker.R * Vector3{half, -half, 0},
          marker.R * Vector3{half, half, 0}, marker.R * Vector3{-half, half, 0}};
}

// Derivatives of w x arm + dt by (w, dt).
std::array<std::array<double, 6>, 3> Motion(const Vector3& arm) {
  return {{{0, arm[2], -arm[1], 1, 0, 0},
           {-arm[2], 0, arm[0], 0, 1, 0},
           {arm[1], -arm[0], 0, 0, 0, 1}}};
}

// Sum over the corners of a marker of Motion(a)' Motion(b).
template <typename A, typename B>
void AddProducts(const ObjectMarker& marker, A first, B second, Matrix6* sum) {
  for (const Vector3& arm : Arms(marker)) {
    const auto a = Motion(first(arm)), b = Motion(second(arm));
    for (size_t c = 0; c < 3; ++c) {
      for (size_t i = 0; i < 6; ++i) {
        for (size_t k = 0; k < 6; ++k) (*sum)[i][k] += a[c][i] * b[c][k];
      }
    }
  }
}

// The inverse of the normal equations of a motion of the whole object.
Matrix6 InverseNormal(const Object& object) {
  Matrix6 normal{};
  for (const ObjectMarker& marker : object.markers) {
    const auto place = [&](const Vector3& arm) { return marker.t + arm; };
    AddProducts(marker, place, place, &normal);
  }
  Matrix6 inverse{};
  InvertPositive(normal[0].data(), 6, inverse[0].data());
  return inverse;
}

}  // namespace

RigidTransform FitFrame(const Object& object, const Object& target) {
  Object moved = object;
  RigidTransform total;
  for (int i = 0; i < kIterations; ++i) {
    std::array<double, 6> gradient{};
    for (size_t m = 0; m < moved.markers.size(); ++m) {
      const auto arms = Arms(moved.markers[m]), wanted = Arms(target.markers[m]);
      for (size_t c = 0; c < 4; ++c) {
        const Vector3 place = moved.markers[m].t + arms[c];
        const Vector3 off = target.markers[m].t + wanted[c] - place;
        const auto motion = Motion(place);
        for (size_t k = 0; k < 6; ++k) {
          gradient[k] += motion[0][k] * off[0] + motion[1][k] * off[1] + motion[2][k] * off[2];
        }
      }
    }
    const Matrix6 inverse = InverseNormal(moved);
    std::array<double, 6> step{};
    for (size_t r = 0; r < 6; ++r) {
      for (size_t k = 0; k < 6; ++k) step[r] += inverse[r][k] * gradient[k];
    }
    const RigidTransform motion{SmallRotation({step[0], step[1], step[2]}),
                                {step[3], step[4], step[5]}};
    total = motion * total;
    for (size_t m = 0; m < moved.markers.size(); ++m) {
      moved.markers[m].R = total.R * object.markers[m].R;
      moved.markers[m].t = total * object.markers[m].t;
    }
  }
  total.R = Orthonormalized(total.R);
  return total;
}

std::vector<Matrix6> CovarianceInFittedFrame(const Object& object,
                                             const std::vector<double>& covariance) {
  const size_t count = object.markers.size();
  const size_t side = 6 * count;
  const Matrix6 inverse = InverseNormal(object);
  // The motion that an error of the markers makes FitFrame take back: 6 x side.
  std::vector<double> taken(6 * side);
  for (size_t m = 0; m < count; ++m) {
    const ObjectMarker& marker = object.markers[m];
    Matrix6 product{};
    AddProducts(
        marker, [&](const Vector3& arm) { return marker.t + arm; },
        [](const Vector3& arm) { return arm; }, &product);
    for (size_t i = 0; i < 6; ++i) {
      for (size_t k = 0; k < 6; ++k) {
        for (size_t j = 0; j < 6; ++j) taken[i * side + 6 * m + k] += inverse[i][j] * product[j][k];
      }
    }
  }
  std::vector<Matrix6> result(count);
  std::vector<double> rows(6 * side), product(6 * side);
  for (size_t m = 0; m < count; ++m) {
    // A motion (w, dt) of the object moves the marker by (w, w x t + dt).
    const auto motion = Motion(object.markers[m].t);
    for (size_t k = 0; k < side; ++k) {
      for (size_t i = 0; i < 3; ++i) {
        rows[i * side + k] = -taken[i * side + k];
        double moved = 0;
        for (size_t j = 0; j < 6; ++j) moved += motion[i][j] * taken[j * side + k];
        rows[(i + 3) * side + k] = -moved;
      }
    }
    for (size_t i = 0; i < 6; ++i) rows[i * side + 6 * m + i] += 1;
    for (size_t i = 0; i < 6; ++i) {
      for (size_t k = 0; k < side; ++k) {
        double sum = 0;
        for (size_t j = 0; j < side; ++j) sum += rows[i * side + j] * covariance[j * side + k];
        product[i * side + k] = sum;
      }
    }
    for (size_t i = 0; i < 6; ++i) {
      for (size_t k = 0; k < 6; ++k) {
        double sum = 0;
        for (size_t j = 0; j < side; ++j) sum += product[i * side + j] * rows[k * side + j];
        result[m][i][k] = sum;
      }
    }
  }
  return result;
}

}  // namespace topotag
