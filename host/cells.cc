#include "host/cells.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

namespace topotag {
namespace {

constexpr int kBodyPoints = 16;
constexpr int kGapPoints = 32;
// Around a centre, in the middle of a square or round body, units.
constexpr Point2 kBody[kBodyPoints] = {
    {1, 0},  {1, 0.5},   {0.85, 0.85},   {0.5, 1},   {0, 1},  {-0.5, 1}, {-0.85, 0.85}, {-1, 0.5},
    {-1, 0}, {-1, -0.5}, {-0.85, -0.85}, {-0.5, -1}, {0, -1}, {0.5, -1}, {0.85, -0.85}, {1, -0.5}};
// In the middle of the gap, half a unit apart.
constexpr Point2 kGap[kGapPoints] = {
    {2, 0},  {2, 0.5},   {2, 1},   {2, 1.5},   {2, 2},   {1.5, 2},   {1, 2},   {0.5, 2},
    {0, 2},  {-0.5, 2},  {-1, 2},  {-1.5, 2},  {-2, 2},  {-2, 1.5},  {-2, 1},  {-2, 0.5},
    {-2, 0}, {-2, -0.5}, {-2, -1}, {-2, -1.5}, {-2, -2}, {-1.5, -2}, {-1, -2}, {-0.5, -2},
    {0, -2}, {0.5, -2},  {1, -2},  {1.5, -2},  {2, -2},  {2, -1.5},  {2, -1},  {2, -0.5}};
// Just inside the edge of the body: dark unless something bright covers it.
constexpr Point2 kEdge[] = {{1.25, 0}, {-1.25, 0}, {0, 1.25}, {0, -1.25}};
// Of the points of a body and of a gap that must be seen of any node, and in a row for its centre
// to be: what has a straight edge then leaves half a unit beside it. Texture leaves no long rows.
constexpr int kMinBody = 12;
constexpr int kMinGap = 10;
constexpr int kMinGapForDark = 19;
constexpr int kMinBodyForBright = 13;
constexpr int kMinGapForBright = 17;
// Black and white of what is seen, compared with those of the whole marker, in parts of the
// contrast.
constexpr double kMaxInkError = 0.35;

Point2 Sum(Point2 a, Point2 b) { return {a.x + b.x, a.y + b.y}; }

int Count(const bool* seen, int points) {
  return static_cast<int>(std::count(seen, seen + points, true));
}

// The longest row of points that are seen, around the ring.
int LongestArc(const bool* seen, int points) {
  int longest = 0;
  int length = 0;
  for (int i = 0; i < 2 * points; ++i) {
    length = seen[i % points] ? length + 1 : 0;
    longest = std::max(longest, length);
  }
  return std::min(longest, points);
}

}  // namespace

float GreyReader::At(Point2 tag) const {
  const Point2 p = map_.Pixel(tag);
  if (!(p.x >= 0 && p.y >= 0 && p.x <= image_.width - 1 && p.y <= image_.height - 1)) return NAN;
  const int x = static_cast<int>(p.x);
  const int y = static_cast<int>(p.y);
  const auto fx = static_cast<float>(p.x - x);
  const auto fy = static_cast<float>(p.y - y);
  const uint8_t* upper = image_.row(y) + x;
  const uint8_t* lower = y + 1 < image_.height ? upper + image_.stride : upper;
  const int right = x + 1 < image_.width ? 1 : 0;
  const float top = static_cast<float>(upper[0]) * (1 - fx) + static_cast<float>(upper[right]) * fx;
  const float bottom =
      static_cast<float>(lower[0]) * (1 - fx) + static_cast<float>(lower[right]) * fx;
  return top * (1 - fy) + bottom * fy;
}

void MeasureInk(const GreyReader& reader, Point2 center, float* black, float* white) {
  float body[kBodyPoints], gap[kGapPoints];
  for (int i = 0; i < kBodyPoints; ++i) {
    body[i] = reader.At(Sum(center, kBody[i]));
    if (std::isnan(body[i])) body[i] = 255;
  }
  for (int i = 0; i < kGapPoints; ++i) {
    gap[i] = reader.At(Sum(center, kGap[i]));
    if (std::isnan(gap[i])) gap[i] = 0;
  }
  std::sort(body, body + kBodyPoints);
  std::sort(gap, gap + kGapPoints);
  const float body_sum = std::accumulate(body, body + kBodyPoints / 2, 0.0F);
  const float gap_sum = std::accumulate(gap + kGapPoints / 2, gap + kGapPoints, 0.0F);
  *black = body_sum / (kBodyPoints / 2);
  *white = gap_sum / (kGapPoints / 2);
}

InkLevels::Plane FitInkPlane(const Point2* at, const float* level, int count) {
  double x = 0, y = 0, mean = 0;
  for (int i = 0; i < count; ++i) {
    x += at[i].x;
    y += at[i].y;
    mean += level[i];
  }
  x /= count;
  y /= count;
  mean /= count;
  double xx = 0, xy = 0, yy = 0, lx = 0, ly = 0;
  for (int i = 0; i < count; ++i) {
    const double dx = at[i].x - x, dy = at[i].y - y, dl = level[i] - mean;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
    lx += dx * dl;
    ly += dy * dl;
  }
  const double det = xx * yy - xy * xy;
  InkLevels::Plane plane{mean, 0, 0};
  if (det > 1e-6 * xx * yy) {
    plane.x = (yy * lx - xy * ly) / det;
    plane.y = (xx * ly - xy * lx) / det;
    plane.level = mean - plane.x * x - plane.y * y;
  }
  return plane;
}

CellReading ReadCell(const GreyReader& reader, Point2 center, const InkLevels& ink, bool is_whole) {
  CellReading cell;
  const double black = ink.black.At(center);
  const double white = ink.white.At(center);
  const double reach = kMaxInkError * (white - black);
  bool body[kBodyPoints], gap[kGapPoints];
  double body_sum = 0, gap_sum = 0;
  for (int i = 0; i < kBodyPoints; ++i) {
    const float level = reader.At(Sum(center, kBody[i]));
    body[i] = std::abs(level - black) < reach;
    if (body[i]) body_sum += level;
  }
  for (int i = 0; i < kGapPoints; ++i) {
    const float level = reader.At(Sum(center, kGap[i]));
    gap[i] = std::abs(level - white) < reach;
    if (gap[i]) gap_sum += level;
  }
  const int bodies = Count(body, kBodyPoints);
  const int gaps = Count(gap, kGapPoints);
  const float center_level = reader.At(center);
  if (bodies < kMinBody || gaps < kMinGap || std::isnan(center_level)) return cell;
  cell.is_node = true;
  cell.is_clean = bodies == kBodyPoints && gaps == kGapPoints;
  for (const Point2 p : kEdge) {
    cell.is_clean &= reader.At(Sum(center, p)) < (black + white) / 2;
  }
  const int gap_arc = LongestArc(gap, kGapPoints);
  cell.shows_dark_center = is_whole || gap_arc >= kMinGapForDark;
  cell.shows_bright_center = is_whole || (LongestArc(body, kBodyPoints) >= kMinBodyForBright &&
                                          gap_arc >= kMinGapForBright);
  const double own_black = body_sum / bodies;
  cell.hole = static_cast<float>((center_level - own_black) / (gap_sum / gaps - own_black));
  return cell;
}

bool IsBaseline(const GreyReader& reader, Point2 corner, Point2 x, Point2 y, const InkLevels& ink,
                float hole, float* holes, bool* is_clean) {
  // In units from p1, along x and y.
  constexpr Point2 kDark[] = {{-1, -0.5}, {-1, 0.5}, {0, -1}, {0, 1},    {1, -1}, {1, 0},
                              {1, 1},     {2, -1},   {2, 1},  {3, -0.5}, {3, 0.5}};
  constexpr Point2 kBehind[] = {{4.5, -0.5}, {4.5, 0.5}, {5, -1}, {5, 0}, {5, 1}};
  constexpr Point2 kAround[] = {{-2, -1}, {-2, 0},  {-2, 1}, {-1, 2}, {0, 2},  {1, 2}, {2, 2},
                                {3, 2},   {-1, -2}, {0, -2}, {1, -2}, {2, -2}, {3, -2}};
  constexpr int kMinAround = 4;
  const auto at = [&](Point2 p) {
    return Point2{corner.x + p.x * x.x + p.y * y.x, corner.y + p.x * x.y + p.y * y.y};
  };
  const auto relative = [&](Point2 p) {
    const Point2 tag = at(p);
    const double black = ink.black.At(tag);
    return (reader.At(tag) - black) / (ink.white.At(tag) - black);
  };
  double body = 0;
  int dark = 0;
  for (const Point2 p : kDark) {
    const double level = relative(p);
    if (!(level < 0.5)) continue;
    ++dark;
    body += level;
  }
  if (dark + 1 < static_cast<int>(std::size(kDark))) return false;
  body /= dark;
  for (const Point2 p : kBehind) {
    if (!(relative(p) > 0.5)) return false;
  }
  int around = 0;
  for (const Point2 p : kAround) around += relative(p) > 0.5;
  if (around < kMinAround) return false;
  constexpr Point2 kEdges[] = {{-1.25, 0}, {0, -1.25}, {0, 1.25}, {2, -1.25}, {2, 1.25}, {3.25, 0}};
  *is_clean =
      dark == static_cast<int>(std::size(kDark)) && around == static_cast<int>(std::size(kAround));
  for (const Point2 p : kEdges) *is_clean &= relative(p) < 0.5;
  for (int i = 0; i < 2; ++i) {
    holes[i] = static_cast<float>((relative({2.0 * i, 0}) - body) / (1 - body));
    if (!(holes[i] > hole)) return false;
  }
  return true;
}

}  // namespace topotag
