#ifndef TOPOTAG_DETECTION_H_
#define TOPOTAG_DETECTION_H_

#include <array>
#include <cstdint>
#include <optional>

#include "topotag/error.h"
#include "topotag/family.h"
#include "topotag/geometry.h"

namespace topotag {

/// The n*n vertices of a marker, in the order of ModelVertices; no allocation.
class VertexList {
 public:
  int size() const { return size_; }
  /// @throws Error (kInvalidArgument) unless 0 <= size <= kMaxVertices
  void resize(int size) {
    if (size < 0 || size > kMaxVertices) {
      throw Error(ErrorCode::kInvalidArgument, "no marker has so many vertices");
    }
    size_ = size;
  }
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

/// What aligning the model of a marker with the image has found (PoseMode::kPhotometric).
struct Photometric {
  bool accepted = false;  ///< else the pose is that of the vertices
  double sigma = 0;       ///< of the residuals, robust, grey levels
  double noise = 0;       ///< expected of the image: between neighbouring residuals, grey levels
  double blur_px = 0;     ///< sigma of the point spread function, the pixel's square left out
  double black = 0;       ///< grey levels at the tag's origin; of an inverted marker's nodes
  double white = 0;
  double growth = 0;  ///< by which black areas are larger on each side than designed, units
  int pixels = 0;     ///< that were used
};

struct Pose : PoseSolution {
  /// Of (rotation vector [rad], translation [m]): R' = exp(w) R, t' = t + dt.
  Matrix6 covariance{};
  /// The other local minimum of the planar pose problem, where there is one.
  std::optional<PoseSolution> alternative;
  /// rms_px of the better over that of the other solution, of the vertices; 0 where there is none.
  double ambiguity = 0;
  /// Set where the photometric step was tried.
  std::optional<Photometric> photometric;
};

/// How well a marker is seen. Deterministic, as the vertices are.
struct Quality {
  /// White less black: gaps less the bodies of nodes, mean of all of them; grey levels.
  double contrast = 0;
  /// How far the least certain bit is from its decision, 0 .. 1: 1 where its hole is as bright, or
  /// as dark, as the marker's others of its kind, 0 half-way between both kinds. Hidden bits do not
  /// count. It falls with noise, low contrast and what touches a node.
  double decision = 0;
  /// How far holes are resolved: holes less solid nodes, in parts of the contrast; about 1 where
  /// they are as bright as the gaps. It falls with blur and distance.
  double sharpness = 0;
  /// Root mean square distance of the measured vertices from a homography fitted to them, pixels
  /// without the lens's distortion. 0 with Options::far's markers, whose vertices are the map's.
  double rms_px = 0;
};

struct Detection {
  Family family{Family::kMinN};
  uint64_t id = 0;                ///< unknown bits are 0
  uint64_t unknown_bits = 0;      ///< bits of the ID whose nodes are hidden: Options::hidden_nodes
  bool inverted = false;          ///< white and black are exchanged: Options::inverted
  Point2 center;                  ///< image of the tag's origin, pixels
  std::array<Point2, 4> corners;  ///< white square: first at p1, then along +x, clockwise; pixels
  /// Sub-pixel, pixels. Those of nodes that are hidden or touched by what hides others are where
  /// the rest of the marker puts them, and have no weight in the pose.
  VertexList vertices;
  /// Of a marker that was read by matched filters (Options::far): log-likelihood of its bits less
  /// that of the nearest other ones, nats.
  std::optional<double> margin;
  Quality quality;
  std::optional<Pose> pose;  ///< needs a camera and a tag size
};

}  // namespace topotag

#endif  // TOPOTAG_DETECTION_H_
