#ifndef TOPOTAG_HOST_HOMOGRAPHY_H_
#define TOPOTAG_HOST_HOMOGRAPHY_H_

#include "topotag/camera.h"
#include "topotag/geometry.h"

namespace topotag {

/// A projective map of the plane, m[2][2] = 1.
struct Homography {
  Matrix3 m{};

  double Denominator(Point2 p) const { return m[2][0] * p.x + m[2][1] * p.y + m[2][2]; }
  Point2 Map(Point2 p) const {
    const double w = 1 / Denominator(p);
    return {(m[0][0] * p.x + m[0][1] * p.y + m[0][2]) * w,
            (m[1][0] * p.x + m[1][1] * p.y + m[1][2]) * w};
  }
  Point2 Map(Point2 p, Jacobian2* jacobian) const {
    const double w = 1 / Denominator(p);
    const Point2 q{(m[0][0] * p.x + m[0][1] * p.y + m[0][2]) * w,
                   (m[1][0] * p.x + m[1][1] * p.y + m[1][2]) * w};
    *jacobian = {(m[0][0] - q.x * m[2][0]) * w, (m[0][1] - q.x * m[2][1]) * w,
                 (m[1][0] - q.y * m[2][0]) * w, (m[1][1] - q.y * m[2][1]) * w};
    return q;
  }
};

/// The map that takes the corners (-half, -half), (half, -half), (half, half), (-half, half) of a
/// square to the corners of a quadrilateral.
/// @return false where there is none, or the horizon cuts through the square.
bool SquareToQuad(double half, const Point2* quad, Homography* homography);

/// Least-squares fit of to[i] = H from[i], in units of `to`, for n >= 4 points. The origin of
/// `from` must lie among the points.
///
/// One linear solution, each equation weighted by 1 / denominator^2 of `guess`, a map that is near
/// to the fitted one: so the residuals are distances.
/// @return false where the points do not determine a map, or the horizon cuts through them.
bool FitHomography(const Point2* from, const Point2* to, int n, const Homography& guess,
                   Homography* homography);

/// @return false where the map cannot be inverted.
bool Invert(const Homography& homography, Homography* inverse);

/// Tag units to pixels: a homography to ideal pixels (fx x/z + cx, fy y/z + cy), then the lens.
/// Without a camera both kinds of pixels are the same.
struct TagMap {
  Homography ideal;
  const Camera* camera = nullptr;

  bool HasLens() const { return camera != nullptr && camera->model != DistortionModel::kNone; }
  Point2 Pixel(Point2 tag) const { return HasLens() ? LensPixel(tag, nullptr) : ideal.Map(tag); }
  Point2 Pixel(Point2 tag, Jacobian2* jacobian) const {
    return HasLens() ? LensPixel(tag, jacobian) : ideal.Map(tag, jacobian);
  }

 private:
  Point2 LensPixel(Point2 tag, Jacobian2* jacobian) const;
};

/// Pixel to ideal pixel; the same point without a camera.
/// @return false outside the lens model's range.
bool PixelToIdeal(const Camera* camera, Point2 pixel, Point2* ideal);

}  // namespace topotag

#endif  // TOPOTAG_HOST_HOMOGRAPHY_H_
