#include "host/leak.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/blur.h"
#include "host/levels.h"
#include "host/model.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

// With more pixels than this in the shorter height of a unit nothing leaks at the usual blur.
constexpr double kMaxHeight = 5.5;
constexpr double kGap = 1;        // between a node and what lies beyond, units
constexpr double kInside = 0.05;  // mean distance of what leaks in from the support's edge, units
constexpr double kPixelVariance = 1.0 / 12;
// The vertices, a corner of each node, the frame beside the cells of the border.
constexpr int kMaxSamples = 2 * kMaxVertices + 4 * Family::kMaxN + kRingPoints;

enum Side { kLeft, kRight, kTop, kBottom, kSides };

// What is measured, and what is around it. Lengths in units.
struct Target {
  bool is_baseline;
  int row, column;  // in the grid; of the baseline node those of p1
  double x;         // of its centre
  Point2 half;      // of its sides
  Point2 height;    // of a unit, pixels
  double growth;    // of its support into the gaps
  bool at_frame[kSides];
  double frame[kSides];  // grey levels of the frame where it is at it
  float white;           // of the gaps around it

  double ReachX() const { return half.x + growth; }
  double ReachY() const { return half.y + growth; }
};

// @param height  the mean of all
void FindTargets(const Decoded& decoded, const Supports& s, const int* vertex, int count,
                 Target* targets, UnitHeights* height) {
  const int n = decoded.family.n();
  const Point2* model = ModelTable(decoded.family);
  *height = {};
  int row = 0;
  for (int i = 0; i < count; ++i) {
    Target& t = targets[i];
    t.is_baseline = vertex[i] == decoded.family.vertex_count();
    while (vertex[i] >= (row + 1) * n) ++row;
    t.row = t.is_baseline ? 0 : row;
    t.column = t.is_baseline ? 0 : vertex[i] - row * n;
    t.x = model[vertex[i]].x;
    t.half = {s.half_x[i], s.half_y[i]};
    const float xu = s.xu[i], xv = s.xv[i], yu = s.yu[i], yv = s.yv[i];
    const float area = std::abs(xu * yv - xv * yu);
    t.height = {area / std::sqrt(yv * yv + xv * xv), area / std::sqrt(xu * xu + yu * yu)};
    t.growth = SupportGrowth(area, s.half_y[i]);
    t.at_frame[kLeft] = t.column == 0;
    t.at_frame[kRight] = t.column == n - 1;
    t.at_frame[kTop] = t.row == 0;
    t.at_frame[kBottom] = t.row == n - 1;
    t.white = decoded.levels[static_cast<size_t>(vertex[i])].white;
    height->u += t.height.x / count;
    height->v += t.height.y / count;
    height->area += area / count;
  }
}

// Grey levels at places in the picture.
class Samples {
 public:
  void Add(double x, double y) {
    near_ &= std::abs(x) < kMaxImageSide && std::abs(y) < kMaxImageSide;
    x_[size_] = near_ ? static_cast<int32_t>(x * (1 << kPlaceShift)) : 0;
    y_[size_++] = near_ ? static_cast<int32_t>(y * (1 << kPlaceShift)) : 0;
  }
  // @return false where one is nowhere near the image
  bool Take(const ImageView& image) {
    if (!near_) return false;
    std::fill(x_ + size_, x_ + size_ + kRingPoints, 0);
    std::fill(y_ + size_, y_ + size_ + kRingPoints, 0);
    SampleLevels(image, x_, y_, size_, levels_);
    return true;
  }
  // In the order in which they were added.
  double Next() { return levels_[next_++] * (1.0 / 256); }

 private:
  bool near_ = true;
  int size_ = 0, next_ = 0;
  int32_t x_[kMaxSamples], y_[kMaxSamples], levels_[kMaxSamples];
};

void AddSamples(const Decoded& decoded, const LocalMaps& maps, const Target* targets, int count,
                Samples* samples) {
  for (int i = 0; i < 2; ++i) {
    const Point2 p = decoded.map.Pixel(ModelTable(decoded.family)[i]);
    samples->Add(p.x, p.y);
  }
  const auto add = [&](int i, double u, double v) {
    samples->Add(maps.x[i] + u * maps.xu[i] + v * maps.xv[i],
                 maps.y[i] + u * maps.yu[i] + v * maps.yv[i]);
  };
  for (int i = 0; i < count; ++i) {
    const Target& t = targets[i];
    if (!t.is_baseline) {
      add(i, 0, 0);
      // Of each node another corner, so that a place that is off does not count.
      add(i, (i & 1) != 0 ? 1.5 : -1.5, (i & 2) != 0 ? 1.5 : -1.5);
    }
    // In the middle of the frame.
    const double u = t.half.x + kGap + 0.5;
    const double v = t.half.y + kGap + 0.5;
    if (t.at_frame[kLeft]) add(i, -u, 0);
    if (t.at_frame[kRight]) add(i, u, 0);
    if (t.at_frame[kTop]) add(i, 0, -v);
    if (t.at_frame[kBottom]) add(i, 0, v);
  }
}

// Also the targets' frames.
// @return false where blur cannot be told
bool FindLevels(const Decoded& decoded, const int* vertex, int count, Samples* samples,
                Target* targets, BlurredLevels* levels) {
  const uint64_t bits = VertexBits(decoded.family, decoded.id);
  double sums[2] = {0, samples->Next() + samples->Next()};  // p1 and p2 are holes
  int counts[2] = {0, 2};
  double bodies = decoded.levels[0].black + decoded.levels[1].black;
  double gaps = 0, corners = 0;
  int nodes = 0;
  for (int i = 0; i < count; ++i) {
    Target& t = targets[i];
    if (!t.is_baseline) {
      const bool has_hole = (bits >> vertex[i] & 1) != 0;
      sums[has_hole] += samples->Next();
      ++counts[has_hole];
      if (has_hole) bodies += decoded.levels[static_cast<size_t>(vertex[i])].black;
      corners += samples->Next();
      gaps += t.white;
      ++nodes;
    }
    for (int side = 0; side < kSides; ++side) {
      if (t.at_frame[side]) t.frame[side] = samples->Next();
    }
  }
  if (nodes == 0) return false;
  levels->hole = sums[1] / counts[1];
  levels->solid = counts[0] > 0;
  levels->black = levels->solid ? sums[0] / counts[0] : bodies / counts[1];
  levels->gap = gaps / nodes;
  levels->corner = corners / nodes;
  return levels->hole > levels->black && levels->gap > levels->hole;
}

// What lies beyond a gap: its extent along the gap within the support, and the first moment of that
// about the support's middle.
struct Cover {
  double length = 0, moment = 0;

  void Add(double from, double to, double reach) {
    from = std::max(from, -reach);
    to = std::min(to, reach);
    if (!(to > from)) return;
    length += to - from;
    moment += 0.5 * (to * to - from * from);
  }
};

// The two nodes below the baseline node, or its two halves above them.
// @param half   of the extent of one
// @param reach  of the support along the gap
Cover CoverOfPair(const Point2* pair, double center, double half, double reach) {
  const double first = pair[0].x - center;
  const double second = pair[1].x - center;
  Cover cover;
  cover.Add(first - half, first + half, reach);
  cover.Add(std::max(second - half, first + half), second + half, reach);
  return cover;
}

// Half of a node's extent along the gap: of a round one the tip, the less the narrower the blur is.
// @param width  of the blur across the gap, units
double HalfExtent(double width, double squareness) {
  const double tip = std::max(2.71 * std::sqrt(width) - 0.41, 0.0);  // fitted to integrals
  return 0.5 * (tip + squareness * (3 - tip));
}

// What is the same around all nodes of a marker.
struct Surroundings {
  Surroundings(const Blur& b, const UnitHeights& height) : blur(b) {
    const double sigma = std::sqrt(blur.variance);
    half_u = HalfExtent(sigma / height.u, blur.squareness);
    half_v = HalfExtent(sigma / height.v, blur.squareness);
    // Blur lets the frame, 1 unit wide, look brighter than it is.
    frame_u = 1 / (blur.contrast * (1 - NormalTail(0.5 * height.u / sigma)));
    frame_v = 1 / (blur.contrast * (1 - NormalTail(0.5 * height.v / sigma)));
    edge = std::sqrt(blur.variance + kPixelVariance);  // the support's edge is 1 pixel wide
    inverse_edge = 1 / edge;
  }

  // What leaks across a gap per unit along it, units.
  // @param height  of a unit across the gap, pixels
  double LeakAcross(double height, double growth) const {
    return edge / height * NormalTailIntegral((kGap - growth) * height * inverse_edge);
  }

  Blur blur;
  double half_u, half_v;      // of a node's extent along gaps that u, and v, lead across
  double frame_u, frame_v;    // darkness of the frame there, per grey level below white
  double edge, inverse_edge;  // width of the blur with that of the support's edge, pixels
};

Point2 LeakInto(const Target& t, const Surroundings& s, Family family) {
  double along[kSides] = {2 * s.half_u, 2 * s.half_u, 2 * s.half_v, 2 * s.half_v};
  for (int side = 0; side < kSides; ++side) {
    if (!t.at_frame[side]) continue;
    const bool sideways = side < kTop;
    const double dark = (s.blur.white - t.frame[side]) * (sideways ? s.frame_u : s.frame_v);
    along[side] = 2 * (sideways ? t.ReachY() : t.ReachX()) * std::clamp(dark, 0.0, 1.0);
  }
  double moment = 0;
  if (t.is_baseline || (t.row == 1 && t.column < 2)) {
    const Point2* pair = ModelTable(family) + (t.is_baseline ? family.n() : 0);
    const Cover cover = CoverOfPair(pair, t.x, s.half_v, t.ReachX());
    along[t.is_baseline ? kBottom : kTop] = cover.length;
    moment = cover.moment;
  }
  // There is more than one gap between the baseline node and the next one.
  if (t.is_baseline) along[kRight] = 0;
  if (t.row == 0 && t.column == 2) along[kLeft] = 0;
  const double u = s.LeakAcross(t.height.x, t.growth);
  const double v = s.LeakAcross(t.height.y, t.growth);
  const double contrast = s.blur.contrast / t.white;
  return {contrast * (u * (t.ReachX() - kInside) * (along[kRight] - along[kLeft]) + v * moment),
          contrast * v * (t.ReachY() - kInside) * (along[kBottom] - along[kTop])};
}

}  // namespace

bool FindLeaks(const ImageView& image, const Decoded& decoded, const LocalMaps& maps,
               const Supports& supports, const int* vertex, int count, double* squareness,
               Point2* leak) {
  Target targets[kMaxPoints];
  UnitHeights height;
  FindTargets(decoded, supports, vertex, count, targets, &height);
  if (!(std::min(height.u, height.v) < kMaxHeight)) return false;
  Samples samples;
  AddSamples(decoded, maps, targets, count, &samples);
  BlurredLevels levels;
  if (!samples.Take(image) || !FindLevels(decoded, vertex, count, &samples, targets, &levels)) {
    return false;
  }
  const Surroundings surroundings(FindBlur(levels, height), height);
  *squareness = surroundings.blur.squareness;
  for (int i = 0; i < count; ++i) leak[i] = LeakInto(targets[i], surroundings, decoded.family);
  return true;
}

}  // namespace topotag
