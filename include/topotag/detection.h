#ifndef TOPOTAG_DETECTION_H_
#define TOPOTAG_DETECTION_H_

#include <array>
#include <cstdint>
#include <optional>

#include "topotag/family.h"
#include "topotag/geometry.h"

namespace topotag {

/// The n*n vertices of a marker, in the order of ModelVertices; no allocation.
class VertexList {
 public:
  int size() const { return size_; }
  void resize(int size) { size_ = size; }
  Point2& operator[](int i) { return points_[i]; }
  const Point2& operator[](int i) const { return points_[i]; }
  Point2* begin() { return points_.data(); }
  Point2* end() { return points_.data() + size_; }
  const Point2* begin() const { return points_.data(); }
  const Point2* end() const { return points_.data() + size_; }

 private:
  std::array<Point2, kMaxVertices> points_{};
  int size_ = 0;
};

/// x_camera = R x_tag + t; camera axes x right, y down, z forward; t in metres.
struct PoseSolution {
  Matrix3 R{};
  Vector3 t{};
  double rms_px = 0;  ///< root mean square reprojection error of the vertices, pixels
};

struct Pose : PoseSolution {
  /// Of (rotation vector [rad], translation [m]): R' = exp(w) R, t' = t + dt.
  Matrix6 covariance{};
  /// The other local minimum of the planar pose problem, where there is one.
  std::optional<PoseSolution> alternative;
};

struct Detection {
  Family family{Family::kMinN};
  uint64_t id = 0;
  Point2 center;                  ///< image of the tag's origin, pixels
  std::array<Point2, 4> corners;  ///< white square: first at p1, then along +x, clockwise; pixels
  VertexList vertices;            ///< sub-pixel, pixels
  std::optional<Pose> pose;       ///< needs a camera and a tag size
};

}  // namespace topotag

#endif  // TOPOTAG_DETECTION_H_
