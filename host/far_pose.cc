#include "host/far_pose.h"

#include <array>

#include "host/cholesky.h"
#include "host/model.h"
#include "host/planar_pose.h"

namespace topotag {
namespace {

using Row6 = std::array<double, 6>;
using Row8 = std::array<double, 8>;

// Derivatives of an ideal pixel by the parameters of the inverse map: the pixel moves so that its
// tag point stays.
void PixelByMap(const Homography& inverse, Point2 pixel, Point2 tag, Row8* x, Row8* y) {
  Jacobian2 j;
  inverse.Map(pixel, &j);
  const double w = 1 / inverse.Denominator(pixel);
  const double det = j[0] * j[3] - j[1] * j[2];
  const Row8 u = {pixel.x * w, pixel.y * w, w, 0, 0, 0, -tag.x * pixel.x * w, -tag.x * pixel.y * w};
  const Row8 v = {0, 0, 0, pixel.x * w, pixel.y * w, w, -tag.y * pixel.x * w, -tag.y * pixel.y * w};
  for (size_t i = 0; i < 8; ++i) {
    (*x)[i] = -(j[3] * u[i] - j[1] * v[i]) / det;
    (*y)[i] = -(j[0] * v[i] - j[2] * u[i]) / det;
  }
}

// Derivatives of an ideal pixel by (rotation vector, translation).
void PixelByPose(const Camera& camera, const Vector3& rotated, const Vector3& t, Row6* x, Row6* y) {
  const Vector3 p{rotated[0] + t[0], rotated[1] + t[1], rotated[2] + t[2]};
  const Vector3 gx{camera.fx / p[2], 0, -camera.fx * p[0] / (p[2] * p[2])};
  const Vector3 gy{0, camera.fy / p[2], -camera.fy * p[1] / (p[2] * p[2])};
  const Vector3 tx = Cross(rotated, gx);
  const Vector3 ty = Cross(rotated, gy);
  *x = {tx[0], tx[1], tx[2], gx[0], gx[1], gx[2]};
  *y = {ty[0], ty[1], ty[2], gy[0], gy[1], gy[2]};
}

}  // namespace

void SetFarCovariance(Family family, const FarReading& reading, const Camera& camera,
                      double tag_size, Pose* pose) {
  const double unit = tag_size / family.white_side();
  const Point2* model = ModelTable(family);
  double normal[36] = {};
  std::array<Row6, 8> mixed{};  // of each parameter of the map
  for (int k = 0; k < family.vertex_count(); ++k) {
    const Point2 tag = model[k];
    const Point2 place = reading.map.Map(tag);
    Row8 mx, my;
    PixelByMap(reading.inverse, {place.x - reading.origin.x, place.y - reading.origin.y}, tag, &mx,
               &my);
    Vector3 rotated;
    for (size_t r = 0; r < 3; ++r) {
      rotated[r] = unit * (pose->R[r][0] * tag.x + pose->R[r][1] * tag.y);
    }
    Row6 px, py;
    PixelByPose(camera, rotated, pose->t, &px, &py);
    for (size_t i = 0; i < 6; ++i) {
      for (size_t m = 0; m <= i; ++m) normal[6 * i + m] += px[i] * px[m] + py[i] * py[m];
      for (size_t m = 0; m < 8; ++m) mixed[m][i] += px[i] * mx[m] + py[i] * my[m];
    }
  }
  if (!Factorize(normal, 6)) return;
  for (Row6& column : mixed) SolveFactorized(normal, 6, column.data());
  for (size_t i = 0; i < 6; ++i) {
    for (size_t k = 0; k < 6; ++k) {
      double sum = 0;
      for (size_t a = 0; a < 8; ++a) {
        for (size_t b = 0; b < 8; ++b) sum += mixed[a][i] * reading.covariance[a][b] * mixed[b][k];
      }
      pose->covariance[i][k] = sum;
    }
  }
}

}  // namespace topotag
