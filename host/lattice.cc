#include "host/lattice.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace topotag {
namespace {

constexpr int kMinCells = 5;
constexpr int kMaxLeftOut = 8;  // crossings, of a grid that has been grown
constexpr int kMaxSeeds = 6;    // of one call
constexpr int kNeighbours = 8;  // of a spot, among which its steps are looked for
// Area of a grid cell in parts of a node's: 16 / 9 for squares, 2.3 for circles; blur, thresholds
// and ink take their share.
constexpr double kMinCellArea = 1.1;
constexpr double kMaxCellArea = 4.5;
// Neighbours differ by perspective; the baseline node has 5 / 3 of a node's area.
constexpr double kMaxAreaRatio = 1.6;
constexpr double kReach = 0.3;         // of a crossing from where it is expected, pitches
constexpr double kMaxResidual = 0.12;  // to the fitted map, pitches
// Of a node to the median, under the fitted map: else something covers a part of it.
constexpr double kMaxPartRatio = 1.4;
constexpr int kSpan = 8;  // columns and rows on either side of the first spot

Point2 operator+(Point2 a, Point2 b) { return {a.x + b.x, a.y + b.y}; }
Point2 operator-(Point2 a, Point2 b) { return {a.x - b.x, a.y - b.y}; }
double Cross(Point2 a, Point2 b) { return a.x * b.y - a.y * b.x; }
double SquaredNorm(Point2 a) { return a.x * a.x + a.y * a.y; }
bool IsLike(double a, double b) { return a < kMaxAreaRatio * b && b < kMaxAreaRatio * a; }

struct Direction {
  int col, row;
};
constexpr Direction kDirections[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

class Grower {
 public:
  Grower(const Spot* spots, int count, const SpotUse* use) : spots_(spots), count_(count) {
    for (int i = 0; i < count; ++i) taken_[i] = use[i] == SpotUse::kTaken;
  }

  // Grows from `seed` with the steps a along the columns and b along the rows, a x b > 0.
  void Grow(int seed, Point2 a, Point2 b, Lattice* lattice) {
    for (auto& column : spot_) std::fill(std::begin(column), std::end(column), -1);
    step_[0] = a;
    step_[1] = b;
    seed_area_ = spots_[seed].area;
    lattice->count = 0;
    Take(seed, 0, 0, lattice);
    for (int i = 0; i < lattice->count; ++i) {
      for (const Direction& d : kDirections) {
        const Lattice::Cell cell = lattice->cells[static_cast<size_t>(i)];
        const int col = cell.col + d.col;
        const int row = cell.row + d.row;
        if (std::abs(col) > kSpan || std::abs(row) > kSpan || At(col, row) >= 0) continue;
        const int next = FindSpot(cell, d);
        if (next >= 0 && lattice->count < Lattice::kMaxCells) Take(next, col, row, lattice);
      }
    }
    for (int i = 0; i < lattice->count; ++i) {
      taken_[lattice->cells[static_cast<size_t>(i)].spot] = false;
    }
  }

 private:
  int& At(int col, int row) { return spot_[col + kSpan + 1][row + kSpan + 1]; }
  Point2 Place(int spot) const { return spots_[spot].at; }

  void Take(int spot, int col, int row, Lattice* lattice) {
    At(col, row) = spot;
    taken_[spot] = true;
    lattice->cells[static_cast<size_t>(lattice->count++)] = {spot, col, row};
  }

  // The step from a cell: as the one before, else as beside it, else as at the seed.
  Point2 Step(const Lattice::Cell& cell, Direction d) {
    const int before = At(cell.col - d.col, cell.row - d.row);
    if (before >= 0) return Place(cell.spot) - Place(before);
    for (const int side : {-1, 1}) {
      const int col = cell.col + side * d.row;
      const int row = cell.row + side * d.col;
      const int beside = At(col, row);
      if (beside < 0 || std::abs(col + d.col) > kSpan || std::abs(row + d.row) > kSpan) continue;
      const int ahead = At(col + d.col, row + d.row);
      if (ahead >= 0) return Place(ahead) - Place(beside);
    }
    const Point2 step = step_[d.row != 0];
    return d.col + d.row > 0 ? step : Point2{-step.x, -step.y};
  }

  int FindSpot(const Lattice::Cell& cell, Direction d) {
    const Point2 expected = Place(cell.spot) + Step(cell, d);
    const double det = Cross(step_[0], step_[1]);
    const double area = spots_[cell.spot].area;
    double nearest = kReach * kReach * det * det * std::min(area / seed_area_, 1.0);
    int found = -1;
    for (int i = 0; i < count_; ++i) {
      const Spot& spot = spots_[i];
      if (taken_[i] || !IsLike(spot.area, area)) continue;
      const Point2 off = spot.at - expected;
      const double u = Cross(off, step_[1]);
      const double v = Cross(step_[0], off);
      if (u * u + v * v < nearest) {
        nearest = u * u + v * v;
        found = i;
      }
    }
    return found;
  }

  const Spot* spots_;
  int count_;
  Point2 step_[2];
  double seed_area_ = 0;
  bool taken_[kMaxSpots];
  int spot_[2 * kSpan + 3][2 * kSpan + 3];
};

void FindBounds(Lattice* lattice) {
  lattice->first_col = lattice->first_row = 99;
  lattice->last_col = lattice->last_row = -99;
  for (int i = 0; i < lattice->count; ++i) {
    const Lattice::Cell& cell = lattice->cells[static_cast<size_t>(i)];
    lattice->first_col = std::min(lattice->first_col, cell.col);
    lattice->last_col = std::max(lattice->last_col, cell.col);
    lattice->first_row = std::min(lattice->first_row, cell.row);
    lattice->last_row = std::max(lattice->last_row, cell.row);
  }
}

int BoxArea(const Lattice& lattice) {
  return (lattice.last_col - lattice.first_col + 1) * (lattice.last_row - lattice.first_row + 1);
}

// The same crossings have many pairs of steps, all but one sheared: that of the smallest box.
void RemoveShear(Lattice* lattice) {
  FindBounds(lattice);
  for (bool smaller = true; smaller;) {
    smaller = false;
    for (const Direction shear : {Direction{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      Lattice other = *lattice;
      for (int i = 0; i < other.count; ++i) {
        Lattice::Cell& cell = other.cells[static_cast<size_t>(i)];
        const int col = cell.col;
        cell.col += shear.col * cell.row;
        cell.row += shear.row * col;
      }
      FindBounds(&other);
      if (BoxArea(other) < BoxArea(*lattice)) {
        *lattice = other;
        smaller = true;
      }
    }
  }
}

// Leaves out the node whose area is farthest from the median, if that is too far.
bool RemoveCovered(const Spot* spots, const Homography& map, double middle_col, double middle_row,
                   Lattice* lattice) {
  double area[Lattice::kMaxCells], sorted[Lattice::kMaxCells];
  const int count = lattice->count;
  for (int i = 0; i < count; ++i) {
    const Lattice::Cell& cell = lattice->cells[static_cast<size_t>(i)];
    Jacobian2 j;
    map.Map({Lattice::kPitch * (cell.col - middle_col), Lattice::kPitch * (cell.row - middle_row)},
            &j);
    area[i] = sorted[i] = spots[cell.spot].area / std::abs(j[0] * j[3] - j[1] * j[2]);
  }
  std::nth_element(sorted, sorted + count / 2, sorted + count);
  const double median = sorted[count / 2];
  int worst = 0;
  double worst_ratio = 0;
  for (int i = 0; i < count; ++i) {
    const double ratio = std::max(area[i] / median, median / area[i]);
    if (ratio > worst_ratio) {
      worst_ratio = ratio;
      worst = i;
    }
  }
  if (worst_ratio < kMaxPartRatio) return false;
  lattice->cells[static_cast<size_t>(worst)] =
      lattice->cells[static_cast<size_t>(--lattice->count)];
  return true;
}

// Fits the map to the crossings and leaves out the worst of them while they are off.
bool FitMap(const Spot* spots, Lattice* lattice) {
  const double middle_col = (lattice->first_col + lattice->last_col) / 2.0;
  const double middle_row = (lattice->first_row + lattice->last_row) / 2.0;
  const int least = std::max(kMinCells, lattice->count - kMaxLeftOut);
  while (lattice->count >= least) {
    Point2 from[Lattice::kMaxCells], to[Lattice::kMaxCells];
    const int count = lattice->count;
    double xx = 0, xy = 0, yy = 0;
    Point2 sum, x_sum, y_sum;
    for (int i = 0; i < count; ++i) {
      const Lattice::Cell& cell = lattice->cells[static_cast<size_t>(i)];
      from[i] = {Lattice::kPitch * (cell.col - middle_col),
                 Lattice::kPitch * (cell.row - middle_row)};
      to[i] = spots[cell.spot].at;
      sum = sum + to[i];
    }
    const Point2 mean{sum.x / count, sum.y / count};
    for (int i = 0; i < count; ++i) {
      const Point2 p = to[i] - mean;
      xx += from[i].x * from[i].x;
      xy += from[i].x * from[i].y;
      yy += from[i].y * from[i].y;
      x_sum = x_sum + Point2{from[i].x * p.x, from[i].x * p.y};
      y_sum = y_sum + Point2{from[i].y * p.x, from[i].y * p.y};
    }
    const double det = xx * yy - xy * xy;
    if (!(det > 1e-6 * xx * yy)) return false;
    Homography guess;
    guess.m = {{{(yy * x_sum.x - xy * y_sum.x) / det, (xx * y_sum.x - xy * x_sum.x) / det, mean.x},
                {(yy * x_sum.y - xy * y_sum.y) / det, (xx * y_sum.y - xy * x_sum.y) / det, mean.y},
                {0, 0, 1}}};
    Homography map, inverse;
    if (!FitHomography(from, to, count, guess, &map) ||
        !FitHomography(from, to, count, map, &map) || !Invert(map, &inverse)) {
      return false;
    }
    int worst = 0;
    double worst_error = 0;
    for (int i = 0; i < count; ++i) {
      const double error = SquaredNorm(inverse.Map(to[i]) - from[i]);
      if (!(error <= worst_error)) {
        worst_error = error;
        worst = i;
      }
    }
    constexpr double kMaxError = kMaxResidual * Lattice::kPitch;
    if (worst_error < kMaxError * kMaxError) {
      if (RemoveCovered(spots, map, middle_col, middle_row, lattice)) continue;
      // The crossings are whole numbers: the map's origin goes to that of columns and rows.
      const double x = -Lattice::kPitch * middle_col;
      const double y = -Lattice::kPitch * middle_row;
      for (Vector3& row : map.m) row[2] += row[0] * x + row[1] * y;
      const double scale = map.m[2][2];
      if (!(std::abs(scale) > 1e-9)) return false;
      for (Vector3& row : map.m) {
        for (double& value : row) value /= scale;
      }
      lattice->map = map;
      FindBounds(lattice);
      return true;
    }
    lattice->cells[static_cast<size_t>(worst)] =
        lattice->cells[static_cast<size_t>(--lattice->count)];
  }
  return false;
}

// The spots nearest to `spot` that are like it.
int FindNeighbours(const Spot* spots, int count, const SpotUse* use, int spot, int* neighbours) {
  double distance[kNeighbours];
  int found = 0;
  for (int i = 0; i < count; ++i) {
    if (i == spot || use[i] == SpotUse::kTaken || !spots[i].is_single ||
        !IsLike(spots[i].area, spots[spot].area)) {
      continue;
    }
    const double d = SquaredNorm(spots[i].at - spots[spot].at);
    int k = found;
    if (found == kNeighbours) {
      if (d >= distance[--k]) continue;
    } else {
      ++found;
    }
    for (; k > 0 && distance[k - 1] > d; --k) {
      distance[k] = distance[k - 1];
      neighbours[k] = neighbours[k - 1];
    }
    distance[k] = d;
    neighbours[k] = i;
  }
  return found;
}

// The largest grid that any two neighbours of the seed lead to.
bool GrowFrom(int seed, const Spot* spots, int count, const SpotUse* use, Lattice* best) {
  int neighbours[kNeighbours];
  const int size = FindNeighbours(spots, count, use, seed, neighbours);
  Grower grower(spots, count, use);
  best->count = 0;
  Lattice lattice;
  for (int i = 0; i < size; ++i) {
    for (int k = 0; k < i; ++k) {
      Point2 a = spots[neighbours[i]].at - spots[seed].at;
      Point2 b = spots[neighbours[k]].at - spots[seed].at;
      if (Cross(a, b) < 0) std::swap(a, b);
      const double cell_area = Cross(a, b) / spots[seed].area;
      if (!(cell_area > kMinCellArea && cell_area < kMaxCellArea)) continue;
      grower.Grow(seed, a, b, &lattice);
      if (lattice.count > best->count) *best = lattice;
    }
  }
  return best->count >= kMinCells;
}

}  // namespace

bool GrowLattice(const Spot* spots, int count, Point2 start, SpotUse* use, Lattice* lattice) {
  for (int tries = 0; tries < kMaxSeeds; ++tries) {
    int seed = -1;
    for (int i = 0; i < count; ++i) {
      if (use[i] != SpotUse::kFree || !spots[i].is_single) continue;
      if (seed < 0 || SquaredNorm(spots[i].at - start) < SquaredNorm(spots[seed].at - start)) {
        seed = i;
      }
    }
    if (seed < 0) return false;
    use[seed] = SpotUse::kTried;
    if (!GrowFrom(seed, spots, count, use, lattice)) continue;
    RemoveShear(lattice);
    if (!FitMap(spots, lattice)) continue;
    for (int i = 0; i < lattice->count; ++i) {
      use[lattice->cells[static_cast<size_t>(i)].spot] = SpotUse::kTaken;
    }
    return true;
  }
  return false;
}

}  // namespace topotag
