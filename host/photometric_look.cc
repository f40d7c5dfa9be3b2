#include "host/photometric_look.h"

#include <algorithm>
#include <cmath>

#include "host/model.h"

namespace topotag {
namespace {

constexpr double kMinContrast = 10;  // grey levels
// Parts of the contrast: deviations of a ring that is all frame or gap, and of an even one; and a
// frame's level from that of the nodes.
constexpr double kUneven = 0.25;
constexpr double kEven = 0.1;
constexpr double kSameLevel = 0.15;
// Darkness at the corners of the square around a node: a quarter for squares, 0.07 where they are
// hardly resolved; hardly any for discs and hexagons.
constexpr double kSquareCorner = 0.05;
// Around a hexagon, corners are darker than the middles of sides by a tenth.
constexpr double kHexagonCorner = 0.035;

// Points on each side of a ring.
constexpr int kRingPoints = 10;

// Bilinear grey level; false outside the image.
bool LevelAt(const ImageView& image, Point2 p, double* level) {
  if (!(p.x >= 0 && p.y >= 0 && p.x <= image.width - 1 && p.y <= image.height - 1)) return false;
  const int x = std::min(static_cast<int>(p.x), std::max(image.width - 2, 0));
  const int y = std::min(static_cast<int>(p.y), std::max(image.height - 2, 0));
  const int right = std::min(x + 1, image.width - 1), below = std::min(y + 1, image.height - 1);
  const double fx = p.x - x, fy = p.y - y;
  const uint8_t* upper = image.row(y);
  const uint8_t* lower = image.row(below);
  *level = (1 - fy) * ((1 - fx) * upper[x] + fx * upper[right]) +
           fy * ((1 - fx) * lower[x] + fx * lower[right]);
  return true;
}

}  // namespace

Point2 ToPixel(const Camera& camera, const Rigid& pose, Point2 tag) {
  const double scale = 1 / (pose.x[2] * tag.x + pose.y[2] * tag.y + pose.t[2]);
  return Project(camera, {(pose.x[0] * tag.x + pose.y[0] * tag.y + pose.t[0]) * scale,
                          (pose.x[1] * tag.x + pose.y[1] * tag.y + pose.t[1]) * scale});
}

double UnitPixels(const Camera& camera, const Rigid& pose, Family family) {
  const double half = family.white_side() / 2.0;
  const Point2 a = ToPixel(camera, pose, {-half, -half}), b = ToPixel(camera, pose, {half, half});
  const Point2 c = ToPixel(camera, pose, {half, -half}), d = ToPixel(camera, pose, {-half, half});
  const double area = std::abs((b.x - a.x) * (d.y - c.y) - (b.y - a.y) * (d.x - c.x)) / 2;
  return std::sqrt(area) / family.white_side();
}

MarkerLook::MarkerLook(const ImageView& image, const Camera& camera, const Rigid& pose,
                       Family family)
    : image_(image), camera_(camera), pose_(pose), family_(family) {
  const auto row = [&](size_t k, double focal, double center) -> Vector3 {
    return {focal * pose.x[k] + center * pose.x[2], focal * pose.y[k] + center * pose.y[2],
            focal * pose.t[k] + center * pose.t[2]};
  };
  x_ = row(0, camera.fx, camera.cx);
  y_ = row(1, camera.fy, camera.cy);
  z_ = {pose.x[2], pose.y[2], pose.t[2]};
  black_ = 0.5 * (MeanAround(1, 0) + MeanAround(0, 1));
  white_ = MeanAround(2, 2);
}

bool MarkerLook::LevelAtTag(Point2 tag, double* level) const {
  if (camera_.model != DistortionModel::kNone) {
    return LevelAt(image_, ToPixel(camera_, pose_, tag), level);
  }
  const double scale = 1 / (z_[0] * tag.x + z_[1] * tag.y + z_[2]);
  return LevelAt(image_,
                 {(x_[0] * tag.x + x_[1] * tag.y + x_[2]) * scale,
                  (y_[0] * tag.x + y_[1] * tag.y + y_[2]) * scale},
                 level);
}

MarkerLook::Ring MarkerLook::MeasureRing(double half) const {
  Ring ring;
  double sum = 0, squares = 0;
  for (int side = 0; side < 4; ++side) {
    for (int k = 0; k < kRingPoints; ++k) {
      const double s = half * (2.0 * k / kRingPoints - 1);
      const Point2 tag = side == 0   ? Point2{s, -half}
                         : side == 1 ? Point2{half, s}
                         : side == 2 ? Point2{-s, half}
                                     : Point2{-half, -s};
      double level;
      if (!LevelAtTag(tag, &level)) {
        ++ring.missing;
        continue;
      }
      sum += level;
      squares += level * level;
      ++ring.count;
    }
  }
  if (ring.count == 0) return ring;
  ring.mean = sum / ring.count;
  ring.deviation = std::sqrt(std::max(squares / ring.count - ring.mean * ring.mean, 0.0));
  return ring;
}

double MarkerLook::MeanAround(double x, double y) const {
  const Point2* model = ModelTable(family_);
  double sum = 0;
  int count = 0;
  const auto add = [&](const Point2& node, double dx, double dy) {
    double level;
    if (!LevelAtTag({node.x + dx, node.y + dy}, &level)) return;
    sum += level;
    ++count;
  };
  for (int k = 2; k < family_.vertex_count(); ++k) {
    // Of four corners two, in turn.
    const double side = k % 2 == 0 ? y : -y;
    add(model[k], x, side);
    add(model[k], -x, -side);
  }
  return count > 0 ? sum / count : 0;
}

// A ring as dark as the nodes where the frame would be, next to a white one; and an even one around
// it.
KnownOutline MarkerLook::FindOutline() const {
  const double half = family_.white_side() / 2.0;
  const Ring white = MeasureRing(half - 0.5);
  const Ring frame = MeasureRing(half + 0.5);
  const double contrast = white.mean - frame.mean;
  if (frame.missing > 0 || contrast < kMinContrast || frame.deviation > kUneven * contrast ||
      white.deviation > kUneven * contrast) {
    return KnownOutline::kNone;
  }
  const double away = 1.5 + std::max(1.0, 1.5 / UnitPixels(camera_, pose_, family_));
  const Ring around = MeasureRing(half + away);
  const bool even = around.missing == 0 && around.deviation < kEven * contrast;
  if (std::abs(frame.mean - black_) < kSameLevel * (white.mean - black_)) {
    return even ? KnownOutline::kFrame : KnownOutline::kWhite;
  }
  return even && frame.deviation < kEven * contrast &&
                 std::abs(frame.mean - around.mean) < kEven * contrast
             ? KnownOutline::kPaper
             : KnownOutline::kNone;
}

InnerShape MarkerLook::FindShape() const {
  const double darkness = (white_ - MeanAround(1.5, 1.5)) / std::max(white_ - black_, 1.0);
  if (darkness > kSquareCorner) return InnerShape::kSquare;
  // Corners of a hexagon, and the middles of its sides, alternate around a circle.
  constexpr double kRadius = 1.6, kCos60 = 0.5, kSin60 = 0.8660254037844386;
  const double corners =
      (MeanAround(kRadius, 0) + 2 * MeanAround(kRadius * kCos60, kRadius * kSin60)) / 3;
  const double sides =
      (MeanAround(0, kRadius) + 2 * MeanAround(kRadius * kSin60, kRadius * kCos60)) / 3;
  const bool has_corners = sides - corners > kHexagonCorner * (white_ - black_);
  return has_corners ? InnerShape::kHexagon : InnerShape::kCircle;
}

}  // namespace topotag
