#include "host/photometric_pixels.h"

#include <algorithm>
#include <cmath>

namespace topotag {
namespace {

// Wider point spread functions see more lines.
constexpr double kFewLinesWidth = 0.3;  // units
// Pixels of a row that are looked at together: between the first and the last, the lens is taken
// for linear to choose among them.
constexpr int kRun = 16;
constexpr int kRowShift = 5;
// Widths of the point spread function within which it sees something.
constexpr double kClear = 2.5;

// The same beyond which a node or a hole that is no square is left out.
constexpr double kSeen = 3.2;

// Of the tag at one pixel.
struct Sight {
  double ux, uy, vx, vy;  // derivatives by the ideal pixel
};

Sight See(const PixelView& view, Point2 at) {
  const double scale = 1 / (view.w[0] + view.w[1] * at.x + view.w[2] * at.y);
  const double u = (view.u[0] + view.u[1] * at.x + view.u[2] * at.y) * scale;
  const double v = (view.v[0] + view.v[1] * at.x + view.v[2] * at.y) * scale;
  return {(view.u[1] - u * view.w[1]) * scale, (view.u[2] - u * view.w[2]) * scale,
          (view.v[1] - v * view.w[1]) * scale, (view.v[2] - v * view.w[2]) * scale};
}

// Order of the expansion in a correlation that leaves less than 3e-4 of the contrast.
int OrderFor(double correlation) {
  double power = correlation * correlation * correlation;
  int order = 2;
  for (; order < kMaxPhotometricOrder && power > 3e-3 * (order + 1); ++order) power *= correlation;
  return order;
}

class Collector {
 public:
  Collector(const ImageView& image, const UnitPattern& pattern, const PixelView& view, double reach,
            PixelWorkspace* workspace)
      : image_(image),
        pattern_(pattern),
        view_(view),
        reach_(reach),
        cells_(workspace->cells),
        lists_(workspace->lists),
        pixels_(workspace->blocks) {}

  int Run();

 private:
  struct Box {
    int x0, y0, x1, y1;  // inclusive; empty where x0 > x1
  };

  bool FindCorners(double reach);
  double ExpectedPixels() const;
  void SetWindow();
  void SetRule();
  void ScanSpan(int y);
  void ScanRuns(int y);
  void Scan(const PixelRun& run);
  int Pack(int first, PixelList* list);
  void SetLens(float* at, int x, int y) const;

  bool IsOutlineKnown() const {
    return pattern_.surroundings() == KnownOutline::kFrame ||
           pattern_.surroundings() == KnownOutline::kPaper;
  }
  bool has_lens() const { return view_.camera->model != DistortionModel::kNone; }
  bool ToIdeal(double x, double y, Point2* ideal) const {
    if (!has_lens()) {
      *ideal = {x - view_.center_x, y - view_.center_y};
      return true;
    }
    const Camera& c = *view_.camera;
    Point2 q;
    if (!Unproject(c, {x, y}, &q)) return false;
    *ideal = {c.fx * q.x + c.cx - view_.center_x, c.fy * q.y + c.cy - view_.center_y};
    return true;
  }

  const ImageView& image_;
  const UnitPattern& pattern_;
  const PixelView& view_;
  const double reach_;
  PhotometricCells& cells_;
  PixelLists& lists_;
  PixelBlocks& pixels_;
  std::array<Point2, 4> corners_;  // ideal pixels
  Box box_;
  ScanRule rule_;
  double width_ = 0;  // largest of the point spread function, units
  int step_ = 1;      // of the rows that are looked at
};

// Of the projected area; the ideal pixel of a tag point follows from the inverse of the view.
bool Collector::FindCorners(double reach) {
  const auto& a = view_.u;
  const auto& b = view_.v;
  const auto& w = view_.w;
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  for (size_t k = 0; k < 4; ++k) {
    const double u = (k & 1) != 0 ? reach : -reach;
    const double v = (k & 2) != 0 ? reach : -reach;
    // (u w - a) . (1, x, y) = 0, (v w - b) . (1, x, y) = 0.
    const double p0 = u * w[0] - a[0], p1 = u * w[1] - a[1], p2 = u * w[2] - a[2];
    const double q0 = v * w[0] - b[0], q1 = v * w[1] - b[1], q2 = v * w[2] - b[2];
    const double det = p1 * q2 - p2 * q1;
    corners_[k] = {(p2 * q0 - p0 * q2) / det, (p0 * q1 - p1 * q0) / det};
    double x = corners_[k].x + view_.center_x;
    double y = corners_[k].y + view_.center_y;
    if (has_lens()) {
      const Camera& c = *view_.camera;
      const Point2 pixel = Project(c, {(x - c.cx) / c.fx, (y - c.cy) / c.fy});
      x = pixel.x;
      y = pixel.y;
    }
    if (!(std::abs(x) < 1e6 && std::abs(y) < 1e6)) return false;
    x0 = std::min(x0, x);
    x1 = std::max(x1, x);
    y0 = std::min(y0, y);
    y1 = std::max(y1, y);
  }
  box_.x0 = std::max(static_cast<int>(std::floor(x0)), 0);
  box_.y0 = std::max(static_cast<int>(std::floor(y0)), 0);
  box_.x1 = std::min(static_cast<int>(std::ceil(x1)), image_.width - 1);
  box_.y1 = std::min(static_cast<int>(std::ceil(y1)), image_.height - 1);
  return box_.x0 <= box_.x1 && box_.y0 <= box_.y1;
}

// By the largest width of the point spread function, and by the largest correlation: at a corner.
void Collector::SetWindow() {
  double width = 0, correlation = 0;
  const auto& c = view_.blur;
  for (const Point2 corner : corners_) {
    const Sight s = See(view_, corner);
    const double uu = c[0] * s.ux * s.ux + 2 * c[1] * s.ux * s.uy + c[2] * s.uy * s.uy;
    const double uv = c[0] * s.ux * s.vx + c[1] * (s.ux * s.vy + s.uy * s.vx) + c[2] * s.uy * s.vy;
    const double vv = c[0] * s.vx * s.vx + 2 * c[1] * s.vx * s.vy + c[2] * s.vy * s.vy;
    width = std::max({width, uu, vv});
    correlation = std::max(correlation, uv * uv / (uu * vv));
  }
  width_ = std::sqrt(width);
  pixels_.sees_next = width * (kSeen + reach_) * (kSeen + reach_) > 1;
  pixels_.lines = width < kFewLinesWidth * kFewLinesWidth ? kFewLines : kManyLines;
  pixels_.order = OrderFor(std::sqrt(correlation));
}

void Collector::SetRule() {
  pattern_.FillCells(pixels_.lines, &cells_);
  const auto row = [](const std::array<double, 3>& r) -> std::array<float, 3> {
    return {static_cast<float>(r[0]), static_cast<float>(r[1]), static_cast<float>(r[2])};
  };
  rule_.cells = &cells_;
  rule_.limit = static_cast<float>(pattern_.reach());
  rule_.near_square = static_cast<float>(reach_ * reach_);
  rule_.seen_square = static_cast<float>(kSeen * kSeen);
  rule_.clear_square = IsOutlineKnown() ? 0 : static_cast<float>(kClear * kClear);
  rule_.u = row(view_.u);
  rule_.v = row(view_.v);
  rule_.w = row(view_.w);
  rule_.blur = static_cast<float>(0.5 * (view_.blur[0] + view_.blur[2]));
  rule_.shape = pattern_.shape();
  rule_.n = pattern_.n();
}

void Collector::Scan(const PixelRun& run) {
  const int most = std::max({lists_.holes.count, lists_.inner.count, lists_.outer.count});
  if (most + run.count <= PixelList::kCapacity) ScanRun(rule_, run, &lists_);
}

// Without lens: that part of a row which the projected area covers.
void Collector::ScanSpan(int y) {
  const double row = y - view_.center_y;
  double first = 1e9, last = -1e9;
  constexpr size_t kAround[] = {0, 1, 3, 2, 0};
  for (size_t k = 0; k < 4; ++k) {
    const Point2 a = corners_[kAround[k]], b = corners_[kAround[k + 1]];
    // A pixel's row may touch the area between its corners only.
    if (std::max(a.y, b.y) < row - 1 || std::min(a.y, b.y) > row + 1) continue;
    for (const double at : {row - 1, row + 1}) {
      const double part = std::clamp((at - a.y) / (a.y == b.y ? 1 : b.y - a.y), 0.0, 1.0);
      const double x = a.x + part * (b.x - a.x);
      first = std::min(first, x);
      last = std::max(last, x);
    }
  }
  const int x0 = static_cast<int>(std::max<double>(std::floor(first + view_.center_x), box_.x0));
  const int x1 = static_cast<int>(std::min<double>(std::ceil(last + view_.center_x), box_.x1));
  if (x0 <= x1) Scan({x0, y, x1 - x0 + 1, x0 - view_.center_x, row, 1, 0});
}

void Collector::ScanRuns(int y) {
  for (int x = box_.x0; x <= box_.x1; x += kRun) {
    // Of large markers some rows, others in each group of columns.
    if ((y + x / kRun * kRowShift) % step_ != 0) continue;
    Point2 first, last;
    if (!ToIdeal(x, y, &first) || !ToIdeal(x + kRun, y, &last)) continue;
    Scan({x, y, std::min(kRun, box_.x1 + 1 - x), first.x, first.y, (last.x - first.x) / kRun,
          (last.y - first.y) / kRun});
  }
}

// Both sides of all edges, at the scale of the tag's centre.
double Collector::ExpectedPixels() const {
  const Sight s = See(view_, {0, 0});
  const double unit = 1 / std::sqrt(std::abs(s.ux * s.vy - s.uy * s.vx));  // pixels
  const double cells = pattern_.n() * pattern_.n();
  const double edges = 14 * cells + 32 * pattern_.n();  // units
  const auto& c = view_.blur;
  return edges * unit * 2 * reach_ * std::sqrt(std::sqrt(c[0] * c[2]));
}

// Where a pixel lies, and how the ideal one changes with it.
void Collector::SetLens(float* at, int x, int y) const {
  const auto set = [at](PixelField field, double value) {
    at[static_cast<size_t>(field) * kPixelLanes] = static_cast<float>(value);
  };
  Point2 ideal;
  if (!ToIdeal(x, y, &ideal)) {
    set(kPixelWeight, 0);
    ideal = {0, 0};
  }
  set(kPixelX, ideal.x);
  set(kPixelY, ideal.y);
  const Camera& c = *view_.camera;
  Jacobian2 forward;
  Project(c, {(ideal.x + view_.center_x - c.cx) / c.fx, (ideal.y + view_.center_y - c.cy) / c.fy},
          &forward);
  const double scale = 1 / (forward[0] * forward[3] - forward[1] * forward[2]);
  set(kPixelLensXx, c.fx * forward[3] * scale);
  set(kPixelLensXy, -c.fx * forward[1] * scale);
  set(kPixelLensYx, -c.fy * forward[2] * scale);
  set(kPixelLensYy, c.fy * forward[0] * scale);
}

// Packs a list into the blocks from `first` on; the block after its last one.
int Collector::Pack(int first, PixelList* list) {
  if (list->count == 0) return first;
  const size_t stride = pixels_.Stride();
  float* blocks = pixels_.fields.data() + static_cast<size_t>(first) * stride;
  PackPixels(rule_, static_cast<int>(view_.center_x), static_cast<int>(view_.center_y), list,
             stride, blocks);
  const auto count =
      static_cast<size_t>((list->count + kPixelLanes - 1) / kPixelLanes) * kPixelLanes;
  for (size_t k = 0; k < count; ++k) {
    const int x = list->places[k] & 0xFFFF, y = list->places[k] >> 16;
    float* at = blocks + k / kPixelLanes * stride + k % kPixelLanes;
    at[kPixelLevel * kPixelLanes] = image_.row(y)[x];
    if (has_lens()) SetLens(at, x, y);
  }
  if (pixels_.shape != InnerShape::kSquare) PackNodeFields(rule_, count, stride, blocks);
  return first + static_cast<int>(count / kPixelLanes);
}

int Collector::Run() {
  if (!FindCorners(pattern_.reach())) return 0;
  SetWindow();
  // The outermost edge is one unit inside where all is known.
  if (IsOutlineKnown() &&
      !FindCorners(std::min(pattern_.reach(), pattern_.reach() - 1 + reach_ * width_)))
    return 0;
  SetRule();
  pixels_.has_lens = has_lens();
  pixels_.shape = pattern_.shape();
  const double area = (box_.x1 - box_.x0 + 1.0) * (box_.y1 - box_.y0 + 1.0);
  step_ = 1 + static_cast<int>(std::min(ExpectedPixels(), area) / kMaxPhotometricPixels);
  for (PixelList* list : {&lists_.holes, &lists_.inner, &lists_.outer}) list->count = 0;
  for (int y = box_.y0; y <= box_.y1; ++y) {
    if (step_ == 1 && !has_lens()) {
      ScanSpan(y);
    } else {
      ScanRuns(y);
    }
  }
  pixels_.hole_blocks = Pack(0, &lists_.holes);
  pixels_.inner_blocks = Pack(pixels_.hole_blocks, &lists_.inner);
  pixels_.blocks = Pack(pixels_.inner_blocks, &lists_.outer);
  return lists_.holes.count + lists_.inner.count + lists_.outer.count;
}

}  // namespace

int CollectPixels(const ImageView& image, const UnitPattern& pattern, const PixelView& view,
                  double reach, PixelWorkspace* workspace) {
  workspace->Reserve();
  return Collector(image, pattern, view, reach, workspace).Run();
}

}  // namespace topotag
