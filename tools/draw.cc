#include "tools/draw.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "tools/report_formats.h"

namespace topotag::tools {
namespace {

// Blue, green, red.
const cv::Scalar kOutline(0, 225, 255);
const cv::Scalar kFirstCorner(0, 80, 255);
const cv::Scalar kVertex(255, 40, 255);
const cv::Scalar kAxes[3] = {{0, 0, 255}, {0, 200, 0}, {255, 80, 0}};
const cv::Scalar kHalo(0, 0, 0);

/// Fractional bits of OpenCV's drawing coordinates.
constexpr int kShift = 4;
constexpr int kAxisSegments = 8;

bool IsDrawable(const Point2& p) { return std::fabs(p.x) < 1e5 && std::fabs(p.y) < 1e5; }

cv::Point Fixed(const Point2& p) {
  const double one = 1 << kShift;
  return {static_cast<int>(std::lround(p.x * one)), static_cast<int>(std::lround(p.y * one))};
}

int Thickness(double width) { return std::max(1, static_cast<int>(std::lround(width))); }

void DrawLine(cv::Mat* picture, const Point2& a, const Point2& b, const cv::Scalar& color,
              double width) {
  if (!IsDrawable(a) || !IsDrawable(b)) return;
  cv::line(*picture, Fixed(a), Fixed(b), color, Thickness(width), cv::LINE_AA, kShift);
}

void DrawDot(cv::Mat* picture, const Point2& center, double radius, const cv::Scalar& color) {
  if (!IsDrawable(center)) return;
  cv::circle(*picture, Fixed(center), static_cast<int>(std::lround(radius * (1 << kShift))), color,
             cv::FILLED, cv::LINE_AA, kShift);
}

double ShortestSide(const Detection& detection) {
  double side = 1e9;
  for (int i = 0; i < 4; ++i) {
    const Point2& a = detection.corners[i];
    const Point2& b = detection.corners[(i + 1) % 4];
    side = std::min(side, std::hypot(a.x - b.x, a.y - b.y));
  }
  return side;
}

void DrawVertices(cv::Mat* picture, const Detection& detection, double unit, double scale) {
  // A cross stays within its node; below two pixels a unit only a dot can be told apart.
  const double arm = std::clamp(0.9 * unit, 0.8, 7 * scale);
  const double width = std::min(unit / 5, 2 * scale);
  for (const Point2& vertex : detection.vertices) {
    if (unit < 2) {
      DrawDot(picture, vertex, arm * 0.7, kVertex);
    } else {
      DrawLine(picture, {vertex.x - arm, vertex.y}, {vertex.x + arm, vertex.y}, kVertex, width);
      DrawLine(picture, {vertex.x, vertex.y - arm}, {vertex.x, vertex.y + arm}, kVertex, width);
    }
  }
}

bool ProjectTagPoint(const Camera& camera, const PoseSolution& pose, const Vector3& tag,
                     Point2* pixel) {
  Vector3 p = pose.t;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) p[row] += pose.R[row][column] * tag[column];
  }
  if (!(p[2] > 0)) return false;
  *pixel = Project(camera, {p[0] / p[2], p[1] / p[2]});
  return true;
}

/// Each axis in short pieces, so that it follows the lens. The farthest is drawn first.
void DrawAxes(cv::Mat* picture, const Pose& pose, const Camera& camera, double length,
              double width) {
  int order[3] = {0, 1, 2};
  std::sort(order, order + 3, [&](int a, int b) { return pose.R[2][a] > pose.R[2][b]; });
  for (const int axis : order) {
    Point2 last;
    Vector3 tag{0, 0, 0};
    if (!ProjectTagPoint(camera, pose, tag, &last)) return;
    for (int i = 1; i <= kAxisSegments; ++i) {
      tag[axis] = length * i / kAxisSegments;
      Point2 next;
      if (!ProjectTagPoint(camera, pose, tag, &next)) break;
      DrawLine(picture, last, next, kAxes[axis], width);
      last = next;
    }
  }
}

/// Above the marker, or below it where the frame ends.
void DrawLabel(cv::Mat* picture, const Detection& detection, double side, double scale) {
  const std::string text = detection.family.name() + " " + IdText(detection);
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  constexpr double kCapHeight = 21;  // of the font at scale 1, pixels
  const double font_scale = std::clamp(side / 7, 11 * scale, 20 * scale) / kCapHeight;
  const int stroke = Thickness(2.2 * font_scale);
  const int halo = stroke + 2 * Thickness(1.3 * font_scale);
  int below = 0;
  const cv::Size size = cv::getTextSize(text, kFont, font_scale, halo, &below);
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  for (const Point2& corner : detection.corners) {
    left = std::min(left, corner.x);
    right = std::max(right, corner.x);
    top = std::min(top, corner.y);
    bottom = std::max(bottom, corner.y);
  }
  // Clear of a frame one unit wide.
  const double gap = 4 * scale + 1.2 * side / detection.family.white_side();
  double y = top - gap;
  if (y - size.height < 0) y = bottom + gap + size.height;
  if (y + below > picture->rows) y = picture->rows - below - 1;
  const double x = std::clamp((left + right - size.width) / 2, 1.0,
                              std::max(1.0, static_cast<double>(picture->cols - size.width - 1)));
  const cv::Point origin(static_cast<int>(x), static_cast<int>(y));
  cv::putText(*picture, text, origin, kFont, font_scale, kHalo, halo, cv::LINE_AA);
  cv::putText(*picture, text, origin, kFont, font_scale, kOutline, stroke, cv::LINE_AA);
}

void DrawDetection(cv::Mat* picture, const Detection& detection, const Options& options,
                   double scale) {
  const double side = ShortestSide(detection);
  const double width = std::clamp(side / 40, 1.0, 2 * scale);
  for (int i = 0; i < 4; ++i) {
    DrawLine(picture, detection.corners[i], detection.corners[(i + 1) % 4], kOutline, width);
  }
  DrawDot(picture, detection.corners[0], std::clamp(side / 18, 1.5, 6 * scale), kFirstCorner);
  DrawVertices(picture, detection, side / detection.family.white_side(), scale);
  if (detection.pose && options.camera) {
    const double tag_size = TagSize(options, detection.family, detection.id);
    DrawAxes(picture, *detection.pose, *options.camera, tag_size / 2,
             std::clamp(side / 30, 1.0, 3 * scale));
  }
}

}  // namespace

double PictureScale(int width, int height) {
  return std::clamp(std::max(width, height) / 1280.0, 1.0, 8.0);
}

void DrawPoseAxes(cv::Mat* picture, const Pose& pose, const Camera& camera, double length) {
  DrawAxes(picture, pose, camera, length, 3 * PictureScale(picture->cols, picture->rows));
}

cv::Mat DrawDetections(const ImageView& image, const std::vector<Detection>& detections,
                       const Options& options) {
  const cv::Mat gray(image.height, image.width, CV_8UC1, const_cast<uint8_t*>(image.data),
                     static_cast<size_t>(image.stride));
  cv::Mat picture;
  cv::cvtColor(gray, picture, cv::COLOR_GRAY2BGR);
  const double scale = PictureScale(image.width, image.height);
  for (const Detection& detection : detections) {
    DrawDetection(&picture, detection, options, scale);
  }
  // Labels last: no neighbour's lines cross them.
  for (const Detection& detection : detections) {
    DrawLabel(&picture, detection, ShortestSide(detection), scale);
  }
  return picture;
}

}  // namespace topotag::tools
