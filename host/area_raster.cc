#include "host/area_raster.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/quadrature.h"

namespace topotag {
namespace {

// Light beyond this many sigmas is dropped: 6e-7 of it.
constexpr double kReachInSigmas = 5;
// Linear interpolation between table rows a 256th of a sigma apart errs by less than 1e-6.
constexpr double kIntervalsPerSigma = 256;

// Antiderivative of the normal distribution function, cut at the reach so that differences of it
// add up to exactly 1.
double NormalIntegral2(double x, double sigma) {
  if (x <= -kReachInSigmas * sigma) return 0;
  if (x >= kReachInSigmas * sigma) return x;
  const double u = x / sigma;
  constexpr double kInvSqrt2Pi = 0.3989422804014327;
  return x * 0.5 * std::erfc(-u * M_SQRT1_2) + sigma * kInvSqrt2Pi * std::exp(-0.5 * u * u);
}

double NormalIntegral(double x, double sigma) {
  if (x <= -kReachInSigmas * sigma) return 0;
  if (x >= kReachInSigmas * sigma) return 1;
  return 0.5 * std::erfc(-x / sigma * M_SQRT1_2);
}

// Two nodes on so short an edge integrate the response to 1e-6.
constexpr double kShortPanelInSigmas = 0.25;

Point2 Mix(Point2 a, Point2 b, double t) { return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t}; }

// A number that is none counts as the low one.
double Within(double value, double low, double high) {
  return value >= low ? std::min(value, high) : low;
}

}  // namespace

PixelResponse::PixelResponse(double sigma)
    : sigma_(sigma < kNegligibleSigma ? 0 : sigma), reach_(0.5 + kReachInSigmas * sigma_) {
  if (!blurred()) return;
  radius_ = static_cast<int>(std::ceil(reach_));
  intervals_ = std::max(16, static_cast<int>(std::ceil(kIntervalsPerSigma / sigma_)));
  profile_.taps = 2 * radius_ + 2;
  step_.taps = 2 * radius_ + 3;
  Fill(&profile_, false);
  Fill(&step_, true);
}

void PixelResponse::Fill(Table* table, bool step) const {
  table->rows.reserve(static_cast<size_t>(intervals_ + 1) * table->taps);
  for (int i = 0; i <= intervals_; ++i) {
    const double first = -radius_ - static_cast<double>(i) / intervals_;
    for (int t = 0; t < table->taps; ++t) {
      const double x = first + t;  // pixel centre relative to the edge point
      if (step) {
        table->rows.push_back(NormalIntegral2(x + 0.5, sigma_) -
                              2 * NormalIntegral2(x - 0.5, sigma_) +
                              NormalIntegral2(x - 1.5, sigma_));
      } else {
        table->rows.push_back(NormalIntegral(x + 0.5, sigma_) - NormalIntegral(x - 0.5, sigma_));
      }
    }
  }
}

int PixelResponse::LookUp(const Table& table, double position, std::vector<double>* weights) const {
  const double whole = std::floor(position);
  const double scaled = (position - whole) * intervals_;
  const int i = std::min(static_cast<int>(scaled), intervals_ - 1);
  const double blend = scaled - i;
  const double* a = table.rows.data() + static_cast<size_t>(i) * table.taps;
  const double* b = a + table.taps;
  weights->resize(table.taps);
  double* out = weights->data();
  for (int t = 0; t < table.taps; ++t) out[t] = a[t] + blend * (b[t] - a[t]);
  return static_cast<int>(whole) - radius_;
}

int PixelResponse::Profile(double position, std::vector<double>* weights) const {
  return LookUp(profile_, position, weights);
}

int PixelResponse::Step(double position, std::vector<double>* weights) const {
  return LookUp(step_, position, weights);
}

AreaRaster::AreaRaster(const PixelResponse& response, const Rect& area)
    : response_(response),
      area_(area),
      // AddSpan writes one cell past the column of an edge on the right border.
      stride_(static_cast<size_t>(area.width) + 2),
      cells_(stride_ * static_cast<size_t>(area.height)) {}

// Green's theorem: the integral over the polygon of f(x) g(y) is the integral along its outline
// of F(x) g(y) dy, F' = f. What is accumulated is the difference of F between neighbouring
// columns, which is zero a few pixels off the outline.
void AreaRaster::Add(const std::vector<Point2>& polygon, double weight) {
  double twice_area = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Point2& a = polygon[i];
    const Point2& b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
    twice_area +=
        (a.x - polygon[0].x) * (b.y - polygon[0].y) - (b.x - polygon[0].x) * (a.y - polygon[0].y);
  }
  const double signed_weight = twice_area > 0 ? -weight : weight;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Point2& a = polygon[i];
    const Point2& b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
    AddEdge({a.x - area_.x, a.y - area_.y}, {b.x - area_.x, b.y - area_.y}, signed_weight);
  }
}

// Cuts an edge down to what matters: nothing above, below or to the right of the rectangle's
// surroundings does, and to the left of them only the rows that the edge spans.
void AreaRaster::AddEdge(Point2 a, Point2 b, double weight) {
  const double reach = response_.reach();
  const double top = -reach, bottom = area_.height - 1 + reach;
  const double left = -reach, right = area_.width - 1 + reach;
  if (a.y == b.y || std::min(a.x, b.x) >= right) return;
  if (std::max(a.y, b.y) <= top || std::min(a.y, b.y) >= bottom) return;
  const auto clip_y = [&](Point2 p) -> Point2 {
    if (p.y >= top && p.y <= bottom) return p;
    const double y = p.y < top ? top : bottom;
    return {a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)), y};
  };
  const Point2 p = clip_y(a), q = clip_y(b);
  // Of corners so far away that the edge between them is no number.
  if (!std::isfinite(p.x) || !std::isfinite(q.x)) return;

  double cuts[4] = {0, 1, 1, 1};
  int pieces = 1;
  const bool rightwards = p.x < q.x;
  for (const double x : {rightwards ? left : right, rightwards ? right : left}) {
    if ((p.x < x) != (q.x < x)) cuts[pieces++] = (x - p.x) / (q.x - p.x);
  }
  for (int i = 0; i < pieces; ++i) {
    Point2 from = i == 0 ? p : Mix(p, q, cuts[i]);
    Point2 to = i + 1 == pieces ? q : Mix(p, q, cuts[i + 1]);
    const double middle = 0.5 * (from.x + to.x);
    if (middle >= right) continue;
    if (middle <= left) from.x = to.x = left;
    // An edge that is longer than a double has digits loses the cut: no node of it may lie where
    // the rows have no cells. Half a pixel is far more than a shorter one is off by.
    from.x = Within(from.x, left - 0.5, right + 0.5);
    to.x = Within(to.x, left - 0.5, right + 0.5);
    AddPiece(from, to, weight);
  }
}

void AreaRaster::AddPiece(Point2 a, Point2 b, double weight) {
  if (response_.blurred()) {
    AddBlurred(a, b, weight);
  } else {
    AddExact(a, b, weight);
  }
}

void AreaRaster::AddBlurred(Point2 a, Point2 b, double weight) {
  const double length = std::hypot(b.x - a.x, b.y - a.y) / response_.sigma();
  if (length <= kShortPanelInSigmas) {
    for (const QuadratureNode& node : kTwoNodes) {
      AddPoint(Mix(a, b, 0.5 + 0.5 * node.position), 0.5 * node.weight * weight * (b.y - a.y));
    }
    return;
  }
  const int panels = static_cast<int>(std::ceil(length / kPanelInSigmas));
  ForEachNode(panels, [&](double position, double share) {
    AddPoint(Mix(a, b, position), share * weight * (b.y - a.y));
  });
}

void AreaRaster::AddPoint(Point2 p, double weight) {
  const int y0 = response_.Profile(p.y, &rows_);
  int x0 = response_.Step(p.x, &columns_);
  // AddEdge has cut off everything that starts right of the rectangle or ends left of it, but for
  // half a pixel.
  const int first = std::max(0, -x0);
  const int last = std::min(static_cast<int>(columns_.size()), area_.width - x0);
  x0 += first;
  // What starts left of the rectangle is complete in column 0.
  for (int i = 0; i < first; ++i) columns_[first] += columns_[i];
  const int end = std::min(static_cast<int>(rows_.size()), area_.height - y0);
  for (int j = std::max(0, -y0); j < end; ++j) {
    double* out = MutableRow(y0 + j) + x0;
    const double w = rows_[j] * weight;
    for (int i = first; i < last; ++i) out[i - first] += w * columns_[i];
  }
}

void AreaRaster::AddExact(Point2 a, Point2 b, double weight) {
  if (a.y > b.y) {
    std::swap(a, b);
    weight = -weight;
  }
  // Cell coordinates: pixel i covers [i, i + 1].
  a = {a.x + 0.5, a.y + 0.5};
  b = {b.x + 0.5, b.y + 0.5};
  const double slope = (b.x - a.x) / (b.y - a.y);
  const int first = std::clamp(static_cast<int>(std::floor(a.y)), 0, area_.height - 1);
  const int last = std::clamp(static_cast<int>(std::ceil(b.y)) - 1, 0, area_.height - 1);
  for (int y = first; y <= last; ++y) {
    const double y0 = std::max<double>(a.y, y), y1 = std::min<double>(b.y, y + 1);
    if (y1 <= y0) continue;
    const double x0 = y0 == a.y ? a.x : a.x + slope * (y0 - a.y);
    const double x1 = y1 == b.y ? b.x : a.x + slope * (y1 - a.y);
    AddSpan(y, std::min(x0, x1), std::max(x0, x1), weight * (y1 - y0));
  }
}

// One edge within one row, spread over the cells between `from` and `to`.
void AreaRaster::AddSpan(int y, double from, double to, double weight) {
  const double width = area_.width;
  from = Within(from, 0, width);
  to = Within(to, from, width);
  double* out = MutableRow(y);
  const double per_x = to > from ? weight / (to - from) : 0;
  for (int x = static_cast<int>(from); x <= static_cast<int>(to); ++x) {
    const double x0 = std::max<double>(from, x), x1 = std::min<double>(to, x + 1);
    const double w = to > from ? per_x * (x1 - x0) : weight;
    const double right_part = w * (0.5 * (x0 + x1) - x);
    out[x] += w - right_part;
    out[x + 1] += right_part;
  }
}

void AreaRaster::Finish() {
  for (int y = 0; y < area_.height; ++y) {
    double* cells = MutableRow(y);
    for (int x = 1; x < area_.width; ++x) cells[x] += cells[x - 1];
  }
}

const double* AreaRaster::row(int y) const {
  return cells_.data() + static_cast<size_t>(y - area_.y) * stride_;
}

}  // namespace topotag
