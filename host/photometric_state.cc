#include "host/photometric_state.h"

#include <algorithm>
#include <cmath>

namespace topotag {
namespace {

constexpr double kMinBlur = 0.1;  // square pixels, pixel included

// Inverse of a 3 x 3 matrix with the given columns, by rows.
Matrix3 InverseOfColumns(const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 bc = Cross(b, c);
  const double scale = 1 / Dot(a, bc);
  return {Scaled(bc, scale), Scaled(Cross(c, a), scale), Scaled(Cross(a, b), scale)};
}

}  // namespace

PixelView MakeView(const Camera& camera, const PhotometricState& state) {
  const Rigid& pose = state.pose;
  const Matrix3 inverse = InverseOfColumns(pose.x, pose.y, pose.t);
  PixelView view;
  view.camera = &camera;
  view.center_x = std::floor(camera.fx * pose.t[0] / pose.t[2] + camera.cx);
  view.center_y = std::floor(camera.fy * pose.t[1] / pose.t[2] + camera.cy);
  const double x = (view.center_x - camera.cx) / camera.fx;
  const double y = (view.center_y - camera.cy) / camera.fy;
  // So that w is about 1.
  const double scale = 1 / (inverse[2][0] * x + inverse[2][1] * y + inverse[2][2]);
  const auto row = [&](const Vector3& r) -> std::array<double, 3> {
    return {(r[0] * x + r[1] * y + r[2]) * scale, r[0] / camera.fx * scale,
            r[1] / camera.fy * scale};
  };
  view.u = row(inverse[0]);
  view.v = row(inverse[1]);
  view.w = row(inverse[2]);
  view.blur = state.blur;
  return view;
}

PhotometricModel MakeModel(const Camera& camera, const PixelView& origin,
                           const PhotometricState& state, double huber) {
  const Rigid& pose = state.pose;
  const Matrix3 inverse = InverseOfColumns(pose.x, pose.y, pose.t);
  const double x = (origin.center_x - camera.cx) / camera.fx;
  const double y = (origin.center_y - camera.cy) / camera.fy;
  const double scale = 1 / (inverse[2][0] * x + inverse[2][1] * y + inverse[2][2]);
  const auto row = [&](const Vector3& r) -> std::array<float, 3> {
    return {static_cast<float>((r[0] * x + r[1] * y + r[2]) * scale),
            static_cast<float>(r[0] / camera.fx * scale),
            static_cast<float>(r[1] / camera.fy * scale)};
  };
  PhotometricModel model;
  model.u = row(inverse[0]);
  model.v = row(inverse[1]);
  model.w = row(inverse[2]);
  const Vector3 z = Cross(pose.x, pose.y);
  for (size_t k = 0; k < 3; ++k) model.normal[k] = static_cast<float>(Dot(inverse[k], z));
  model.black = static_cast<float>(state.black);
  model.white = static_cast<float>(state.white);
  model.gain_x = static_cast<float>(state.gain_x);
  model.gain_y = static_cast<float>(state.gain_y);
  model.blur_xx = static_cast<float>(state.blur[0]);
  model.blur_xy = static_cast<float>(state.blur[1]);
  model.blur_yy = static_cast<float>(state.blur[2]);
  model.growth = static_cast<float>(state.growth);
  model.background = static_cast<float>(state.background);
  model.huber = static_cast<float>(huber);
  return model;
}

PhotometricState Apply(const PhotometricState& state, const PhotometricStep& step) {
  PhotometricState next = state;
  const Rigid& pose = state.pose;
  const Vector3 z = Cross(pose.x, pose.y);
  const auto turned = [&](const Vector3& a) -> Vector3 {
    return {pose.x[0] * a[0] + pose.y[0] * a[1] + z[0] * a[2],
            pose.x[1] * a[0] + pose.y[1] * a[1] + z[1] * a[2],
            pose.x[2] * a[0] + pose.y[2] * a[1] + z[2] * a[2]};
  };
  const Vector3 shift = turned({step[kTauX], step[kTauY], step[kTauZ]});
  const Vector3 half = Scaled({step[kOmegaX], step[kOmegaY], step[kOmegaZ]}, 0.5);
  // Cayley's rotation by about `step`.
  const double scale = 2 / (1 + Dot(half, half));
  const auto rotate = [&](const Vector3& a) {
    const Vector3 once = Cross(half, a);
    const Vector3 twice = Cross(half, once);
    return Vector3{a[0] + scale * (once[0] + twice[0]), a[1] + scale * (once[1] + twice[1]),
                   a[2] + scale * (once[2] + twice[2])};
  };
  next.pose.x = turned(rotate({1, 0, 0}));
  next.pose.y = turned(rotate({0, 1, 0}));
  for (size_t k = 0; k < 3; ++k) next.pose.t[k] += shift[k];
  next.black += step[kBlack];
  next.white += step[kWhite];
  next.gain_x += step[kGainX];
  next.gain_y += step[kGainY];
  for (size_t k = 0; k < 3; ++k) next.blur[k] += step[kBlurXx + k];
  next.growth += step[kGrowth];
  next.background += step[kBackground];
  // The blur stays that of a point spread function.
  double& xx = next.blur[0];
  double& yy = next.blur[2];
  xx = std::clamp(xx, std::max(kMinBlur, state.blur[0] / 3), 3 * state.blur[0]);
  yy = std::clamp(yy, std::max(kMinBlur, state.blur[2] / 3), 3 * state.blur[2]);
  const double most = 0.95 * std::sqrt(xx * yy);
  next.blur[1] = std::clamp(next.blur[1], -most, most);
  next.growth = std::clamp(next.growth, -0.4, 0.4);
  return next;
}

}  // namespace topotag
