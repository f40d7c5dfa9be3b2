#include "host/shading.h"

#include <algorithm>
#include <cmath>

namespace topotag {
namespace {

// Largest gradient of the gaps' white by blur alone, per unit, at 1 pixel a unit; it falls with the
// square of the resolution.
constexpr float kBlurShading = 0.5F;
// Largest part of the white that blur takes away at 1 pixel a unit; it falls likewise.
constexpr double kMaxDarkening = 1;

// Squared pixels of the shorter height of a square unit are the inverse of this.
template <typename T>
T InverseSquare(T xu, T xv, T yu, T yv) {
  const T det = xu * yv - xv * yu;
  const T longest = std::max(yv * yv + xv * xv, xu * xu + yu * yu);
  return longest / (det * det);
}

// Least-squares planes over the same points.
class Planes {
 public:
  Planes(const Point2* tag, int count) : tag_(tag), count_(count) {
    for (int i = 0; i < count; ++i) {
      mean_.x += tag[i].x / count;
      mean_.y += tag[i].y / count;
    }
    for (int i = 0; i < count; ++i) {
      const double x = tag[i].x - mean_.x;
      const double y = tag[i].y - mean_.y;
      xx_ += x * x;
      xy_ += x * y;
      yy_ += y * y;
    }
    scale_ = 1 / (xx_ * yy_ - xy_ * xy_);
  }
  Point2 Gradient(const double* values) const {
    double x = 0, y = 0;
    for (int i = 0; i < count_; ++i) {
      x += (tag_[i].x - mean_.x) * values[i];
      y += (tag_[i].y - mean_.y) * values[i];
    }
    return {(x * yy_ - y * xy_) * scale_, (y * xx_ - x * xy_) * scale_};
  }

 private:
  const Point2* tag_;
  int count_;
  Point2 mean_;
  double xx_ = 0, xy_ = 0, yy_ = 0, scale_;
};

}  // namespace

Point2 FitShading(const Point2* tag, const NodeLevels* levels, int count) {
  double white[kMaxPoints];
  for (int i = 0; i < count; ++i) white[i] = levels[i].white;
  return Planes(tag, count).Gradient(white);
}

Point2 FitShading(const Point2* tag, const LocalMaps& maps, const NodeLevels* levels, int count) {
  double white[kMaxPoints], blur[kMaxPoints];
  for (int i = 0; i < count; ++i) {
    white[i] = levels[i].white;
    blur[i] = white[i] * InverseSquare(maps.xu[i], maps.xv[i], maps.yu[i], maps.yv[i]);
  }
  const Planes planes(tag, count);
  const Point2 whole = planes.Gradient(white);
  const Point2 g = planes.Gradient(blur);
  const double against = -(whole.x * g.x + whole.y * g.y);
  const double square = g.x * g.x + g.y * g.y;
  if (!(against > 0)) return whole;
  const double part = std::min(against / square, kMaxDarkening);
  return {whole.x + part * g.x, whole.y + part * g.y};
}

void SetWhite(const NodeLevels* levels, int count, Point2 whole, Supports* supports) {
  Supports& s = *supports;
  const auto whole_u = static_cast<float>(whole.x);
  const auto whole_v = static_cast<float>(whole.y);
  for (int i = 0; i < count; ++i) {
    const float blur =
        kBlurShading * levels[i].white * InverseSquare(s.xu[i], s.xv[i], s.yu[i], s.yv[i]);
    const float u = levels[i].white_u - whole_u;
    const float v = levels[i].white_v - whole_v;
    const float square = u * u + v * v;
    const float trust = square > blur * blur ? 1 - blur / std::sqrt(square) : 0;
    s.white[i] = levels[i].white;
    s.white_u[i] = whole_u + trust * u;
    s.white_v[i] = whole_v + trust * v;
  }
}

}  // namespace topotag
