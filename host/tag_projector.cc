#include "host/tag_projector.h"

#include <algorithm>
#include <cmath>

#include "host/check.h"
#include "host/tag_size.h"

namespace topotag {
namespace {

constexpr double kRotationTolerance = 1e-6;
// Nearer to the camera's plane than this many tag sizes, coordinates lose their precision.
constexpr double kMinDepth = 1e-3;
constexpr int kMaxCircleSegments = 1 << 14;
constexpr int kMaxEdgeDepth = 10;

void ValidateMarker(const SceneMarker& marker, const std::string& name) {
  RequireRange(name + ": tag size", marker.tag_size, kMinTagSize, kMaxTagSize, "metres");
  RequireRange(name + ": black", marker.black, 0, 255);
  RequireRange(name + ": white", marker.white, 0, 255);
  const auto require_finite = [&name](const char* what, const Vector3& values) {
    for (const double value : values) {
      if (!std::isfinite(value)) FailArgument(name + ": " + what + Text(value) + " is not finite");
    }
  };
  require_finite("translation ", marker.t);
  require_finite("velocity ", marker.velocity);
  require_finite("angular velocity ", marker.angular_velocity);
  const Matrix3& r = marker.R;
  bool orthonormal = true;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double dot = r[i][0] * r[j][0] + r[i][1] * r[j][1] + r[i][2] * r[j][2];
      if (!(std::abs(dot - (i == j)) <= kRotationTolerance)) orthonormal = false;
    }
  }
  if (!orthonormal) FailArgument(name + ": R is not a rotation: its rows are not orthonormal");
  const double determinant = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) -
                             r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0]) +
                             r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);
  if (determinant < 0) FailArgument(name + ": R is a reflection, not a rotation");
}

}  // namespace

TagProjector::TagProjector(const Scene& scene, int index)
    : TagProjector(scene, scene.markers[index], index) {}

TagProjector::TagProjector(const Scene& scene, const SceneMarker& marker, int index)
    : camera_(scene.camera),
      marker_(marker),
      name_("marker " + std::to_string(index)),
      unit_(marker_.tag_size / marker_.design.family.white_side()),
      apron_(1 + 6 * scene.blur) {
  ValidateMarker(marker_, name_);
}

Point2 TagProjector::Normalized(Point2 tag) const {
  const Matrix3& r = marker_.R;
  const Vector3& t = marker_.t;
  const double x = tag.x * unit_, y = tag.y * unit_;
  const double z = r[2][0] * x + r[2][1] * y + t[2];
  if (!(z > kMinDepth * marker_.tag_size)) {
    FailArgument(name_ + ": the point (" + Text(tag.x) + ", " + Text(tag.y) +
                 ") units is not in front of the camera: z = " + Text(z) + " m");
  }
  return {(r[0][0] * x + r[0][1] * y + t[0]) / z, (r[1][0] * x + r[1][1] * y + t[1]) / z};
}

Point2 TagProjector::operator()(Point2 tag) const {
  const Point2 pixel = Project(camera_, Normalized(tag));
  if (!std::isfinite(pixel.x) || !std::isfinite(pixel.y)) FailBeyondLens(tag);
  return pixel;
}

Point2 TagProjector::Visible(Point2 tag) const {
  const Point2 pixel = (*this)(tag);
  if (MayShow(pixel, pixel)) CheckLens(tag, pixel);
  return pixel;
}

// A lens model that is not one-to-one shows the point where another point of the scene belongs.
void TagProjector::CheckLens(Point2 tag, Point2 pixel) const {
  if (camera_.model == DistortionModel::kNone) return;
  const Point2 expected = Normalized(tag);
  Point2 actual;
  const double tolerance = 1e-6 * (1 + std::hypot(expected.x, expected.y));
  if (!Unproject(camera_, pixel, &actual) ||
      !(std::hypot(actual.x - expected.x, actual.y - expected.y) <= tolerance)) {
    FailBeyondLens(tag);
  }
}

void TagProjector::FailBeyondLens(Point2 tag) const {
  FailArgument(name_ + ": the point (" + Text(tag.x) + ", " + Text(tag.y) +
               ") units lies beyond the lens model's range");
}

double TagProjector::DistanceToFrame(Point2 pixel) const {
  const double dx = std::max({-0.5 - pixel.x, pixel.x - (camera_.width - 0.5), 0.0});
  const double dy = std::max({-0.5 - pixel.y, pixel.y - (camera_.height - 0.5), 0.0});
  return std::hypot(dx, dy);
}

// True unless the chord surely leaves no trace in the frame.
bool TagProjector::MayShow(Point2 a, Point2 b) const {
  return std::max(a.x, b.x) > -apron_ && std::min(a.x, b.x) < camera_.width + apron_ &&
         std::max(a.y, b.y) > -apron_ && std::min(a.y, b.y) < camera_.height + apron_;
}

std::vector<Point2> TagProjector::Outlined(const std::vector<Point2>& tag) const {
  std::vector<Point2> image;
  Point2 b = (*this)(tag[0]);
  for (size_t i = 0; i < tag.size(); ++i) {
    const Point2 next = tag[i + 1 < tag.size() ? i + 1 : 0];
    const Point2 a = b;
    b = (*this)(next);
    AppendEdge(tag[i], next, a, b, 0, &image);
  }
  return image;
}

// Appends the image of the edge from tag point p to q, whose images are a and b, without b.
void TagProjector::AppendEdge(Point2 p, Point2 q, Point2 a, Point2 b, int depth,
                              std::vector<Point2>* image) const {
  if (camera_.model == DistortionModel::kNone || depth == kMaxEdgeDepth || IsStraight(p, q, a, b)) {
    if (MayShow(a, b)) {
      CheckLens(p, a);
      // Otherwise the next chord, which starts there, checks it.
      if (!MayShow(b, b)) CheckLens(q, b);
    }
    image->push_back(a);
    return;
  }
  const Point2 middle{0.5 * (p.x + q.x), 0.5 * (p.y + q.y)};
  const Point2 c = (*this)(middle);
  AppendEdge(p, middle, a, c, depth + 1, image);
  AppendEdge(middle, q, c, b, depth + 1, image);
}

bool TagProjector::IsStraight(Point2 p, Point2 q, Point2 a, Point2 b) const {
  const double dx = b.x - a.x, dy = b.y - a.y, length = std::hypot(dx, dy);
  const bool visible = MayShow(a, b);
  for (const double s : {0.25, 0.5, 0.75}) {
    const Point2 c = (*this)({p.x + s * (q.x - p.x), p.y + s * (q.y - p.y)});
    const double offset = std::abs((c.x - a.x) * dy - (c.y - a.y) * dx);
    // Far from the frame a coarser outline does, as long as it keeps out of the frame.
    const double slack = visible ? 0 : 0.01 * DistanceToFrame(c);
    const double tolerance = kOutlineTolerance + slack;
    if (!(offset <= tolerance * length)) return false;
  }
  return true;
}

int TagProjector::CircleSegments(const Outline& circle) const {
  constexpr int kProbes = 16;
  const Point2 center = (*this)(circle.center);
  double radius = 1;
  for (int i = 0; i < kProbes; ++i) {
    const double angle = 2 * M_PI * i / kProbes;
    const Point2 p = (*this)({circle.center.x + circle.radius * std::cos(angle),
                              circle.center.y + circle.radius * std::sin(angle)});
    radius = std::max(radius, std::hypot(p.x - center.x, p.y - center.y));
  }
  const double sides = std::min(M_PI * std::sqrt(radius / (2 * kOutlineTolerance)),
                                static_cast<double>(kMaxCircleSegments));
  return 4 * std::max(4, static_cast<int>(std::ceil(sides / 4)));
}

}  // namespace topotag
