#include "host/far_lattice.h"

#include <algorithm>
#include <cmath>

namespace topotag {
namespace {

constexpr double kMinPitch = 2.2, kMaxPitch = 8;  // pixels
constexpr double kFinePitch = 6;                  // up to which full resolution is needed
constexpr double kReach = 9;                      // of a neighbour, pixels
constexpr int kMaxNeighbours = 14;
constexpr int kMaxLines = 8;
// A spot belongs to a lattice point that is nearer than this part of the smaller pitch: the
// baseline node is off by a quarter.
constexpr double kTolerance = 0.35;
constexpr int kMinAround = 5;  // of the eight lattice points around the first
constexpr double kMinSine = 0.45;
constexpr size_t kBlocksPerFamily = 4;
// Blocks that differ by less, pixels, are one.
constexpr double kSameCenter = 0.6, kSameStep = 0.2;
constexpr double kMaxAspect = 4;
// Of the grey levels where gaps cross: above the nodes', and their range and standard deviation in
// parts of that.
constexpr double kMinRise = 10;
constexpr double kMaxSpread = 0.8;
constexpr double kMaxDeviation = 0.3;

double Length(Point2 p) { return std::sqrt(p.x * p.x + p.y * p.y); }
double Cross(Point2 a, Point2 b) { return a.x * b.y - a.y * b.x; }

// The shortest vectors of the lattice that a and b span.
void Reduce(Point2* a, Point2* b) {
  for (int i = 0; i < 4; ++i) {
    if (Length(*a) > Length(*b)) std::swap(*a, *b);
    const double k = std::round((a->x * b->x + a->y * b->y) / (a->x * a->x + a->y * a->y));
    if (!(k != 0)) break;
    b->x -= k * a->x;
    b->y -= k * a->y;
  }
}

}  // namespace

FarLattice::FarLattice(std::vector<Family> families, double min_size)
    : families_(std::move(families)),
      largest_(std::max_element(families_.begin(), families_.end())->n()),
      min_steps_(2 * 4 * min_size / Family(largest_).white_side()) {}

int FarLattice::MinScale() const { return min_steps_ < 2 * kFinePitch ? 1 : 2; }

bool FarLattice::IsPlausible(Point2 a, Point2 b) const {
  const double la = Length(a), lb = Length(b);
  return std::abs(Cross(a, b)) > kMinSine * la * lb && std::min(la, lb) > kMinPitch &&
         std::max(la, lb) < kMaxPitch && std::max(la, lb) < kMaxAspect * std::min(la, lb) &&
         (la + lb) * scale_ > min_steps_;
}

// Spots at the eight lattice points around the first, or less than `least`.
int FarLattice::CountAround(const Lattice& lattice, double tolerance, int least) const {
  int count = 0, left = 8;
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      if (i == 0 && j == 0) continue;
      if (count + left < least) return 0;
      --left;
      count += Nearest(lattice.At(i, j), tolerance) >= 0;
    }
  }
  return count;
}

// Two of the lines through opposite neighbours of the seed.
bool FarLattice::FindBasis(int seed, Lattice* lattice) const {
  const Point2 origin = place_[static_cast<size_t>(seed)];
  std::array<Point2, kMaxNeighbours> neighbour;
  int neighbours = 0;
  const int column = static_cast<int>(origin.x) / kTile, row = static_cast<int>(origin.y) / kTile;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, tile_rows_ - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, tile_cols_ - 1); ++c) {
      const Tile& tile = tiles_[static_cast<size_t>(r * tile_cols_ + c)];
      if (tile.pass != pass_) continue;
      for (int spot = tile.first; spot < tile.first + tile.count; ++spot) {
        const Point2 q = place_[static_cast<size_t>(spot)];
        const Point2 d{q.x - origin.x, q.y - origin.y};
        if (std::max(std::abs(d.x), std::abs(d.y)) > kReach || Length(d) < kMinPitch * 0.8)
          continue;
        // Sorted by distance, the farthest ones left out.
        int k = std::min(neighbours, kMaxNeighbours - 1);
        if (neighbours == kMaxNeighbours && Length(d) >= Length(neighbour[kMaxNeighbours - 1]))
          continue;
        neighbours = std::min(neighbours + 1, kMaxNeighbours);
        for (; k > 0 && Length(neighbour[static_cast<size_t>(k - 1)]) > Length(d); --k) {
          neighbour[static_cast<size_t>(k)] = neighbour[static_cast<size_t>(k - 1)];
        }
        neighbour[static_cast<size_t>(k)] = d;
      }
    }
  }
  if (neighbours < kMinAround) return false;
  std::array<Point2, kMaxLines> line;
  int lines = 0;
  for (int i = 0; i < neighbours; ++i) {
    const Point2 p = neighbour[static_cast<size_t>(i)];
    for (int k = i + 1; k < neighbours; ++k) {
      const Point2 q = neighbour[static_cast<size_t>(k)];
      if (Length({p.x + q.x, p.y + q.y}) > 0.3 * Length(p) + 0.4) continue;
      if (lines < kMaxLines) {
        line[static_cast<size_t>(lines++)] = {(p.x - q.x) / 2, (p.y - q.y) / 2};
      }
      break;
    }
  }
  int best = kMinAround - 1;
  for (int i = 0; i < lines; ++i) {
    for (int k = i + 1; k < lines; ++k) {
      Point2 a = line[static_cast<size_t>(i)];
      Point2 b = line[static_cast<size_t>(k)];
      Reduce(&a, &b);
      if (!IsPlausible(a, b)) continue;
      if (Cross(a, b) < 0) std::swap(a, b);
      const Lattice tried{origin, a, b};
      const int count = CountAround(tried, kTolerance * std::min(Length(a), Length(b)), best + 1);
      if (count > best) {
        best = count;
        *lattice = tried;
      }
    }
  }
  return best >= kMinAround;
}

// Whether where gaps cross, around the seed, it is brighter, and about as bright everywhere.
bool FarLattice::StandsOut(const Lattice& lattice) const {
  double least = INFINITY, most = 0;
  for (const double j : {-0.5, 0.5}) {
    for (const double i : {-0.5, 0.5}) {
      const double grey = Grey(lattice.At(i, j));
      least = std::min(least, grey);
      most = std::max(most, grey);
    }
  }
  const double rise = (least + most) / 2 - Grey(lattice.origin);
  return rise > kMinRise && most - least < kMaxSpread * rise;
}

// The same for all of a block's crossings.
bool FarLattice::HasGaps(const Lattice& block, int n) const {
  double sum = 0, squares = 0, nodes = 0;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) nodes += Grey(block.At(i, j));
  }
  for (int j = 1; j < n; ++j) {
    for (int i = 1; i < n; ++i) {
      const double grey = Grey(block.At(i - 0.5, j - 0.5));
      sum += grey;
      squares += grey * grey;
    }
  }
  const int crossings = (n - 1) * (n - 1);
  const double mean = sum / crossings;
  const double rise = mean - nodes / (n * n);
  return rise > kMinRise &&
         squares / crossings - mean * mean < kMaxDeviation * kMaxDeviation * rise * rise;
}

// Least squares over the points found.
bool FarLattice::Refit(Lattice* lattice) const {
  double n = 0, si = 0, sj = 0, sii = 0, sij = 0, sjj = 0;
  Point2 s, pi, pj;
  for (int j = -kExtent; j <= kExtent; ++j) {
    for (int i = -kExtent; i <= kExtent; ++i) {
      const int spot = found_[static_cast<size_t>(j + kExtent)][static_cast<size_t>(i + kExtent)];
      if (spot < 0) continue;
      const Point2 p = place_[static_cast<size_t>(spot)];
      n += 1, si += i, sj += j, sii += i * i, sij += i * j, sjj += j * j;
      s.x += p.x, s.y += p.y, pi.x += i * p.x, pi.y += i * p.y, pj.x += j * p.x, pj.y += j * p.y;
    }
  }
  const double ci = sii - si * si / n, cj = sjj - sj * sj / n, cij = sij - si * sj / n;
  const double det = ci * cj - cij * cij;
  if (!(det > 0.1)) return false;
  const auto solve = [&](double t, double ti, double tj, double* a, double* b, double* o) {
    const double di = ti - si * t / n, dj = tj - sj * t / n;
    *a = (cj * di - cij * dj) / det;
    *b = (ci * dj - cij * di) / det;
    *o = (t - *a * si - *b * sj) / n;
  };
  solve(s.x, pi.x, pj.x, &lattice->a.x, &lattice->b.x, &lattice->origin.x);
  solve(s.y, pi.y, pj.y, &lattice->a.y, &lattice->b.y, &lattice->origin.y);
  return true;
}

// Collects the lattice's points ring by ring, each next to one that was found.
bool FarLattice::Grow(int seed, Lattice* lattice) {
  for (auto& row : found_) row.fill(-1);
  const auto at = [&](int i, int j) -> int32_t& {
    return found_[static_cast<size_t>(j + kExtent)][static_cast<size_t>(i + kExtent)];
  };
  at(0, 0) = seed;
  reach_ = 0;
  for (int ring = 1; ring < largest_; ++ring) {
    int added = 0;
    const double tolerance = kTolerance * std::min(Length(lattice->a), Length(lattice->b));
    for (int j = -ring; j <= ring; ++j) {
      for (int i = -ring; i <= ring; ++i) {
        if (std::max(std::abs(i), std::abs(j)) != ring) continue;
        const auto known = [&](int di, int dj) {
          return std::max(std::abs(i + di), std::abs(j + dj)) <= ring && at(i + di, j + dj) >= 0;
        };
        const bool joined = known(-1, 0) || known(1, 0) || known(0, -1) || known(0, 1) ||
                            (ring == 1) || known(-1, -1) || known(1, 1) || known(1, -1) ||
                            known(-1, 1);
        if (!joined) continue;
        const int spot = Nearest(lattice->At(i, j), tolerance);
        if (spot < 0) continue;
        at(i, j) = spot;
        ++added;
      }
    }
    if (added == 0) break;
    reach_ = ring;
    if (!Refit(lattice)) return false;
  }
  return Cross(lattice->a, lattice->b) > 0;
}

// Of each family the fullest blocks, in pixels of the whole image at full resolution. Whether one
// is full but for what the baseline node and chance leave out.
bool FarLattice::AddBlocks(const Lattice& lattice, std::vector<FarBlock>* blocks) const {
  struct Place {
    int missing, i, j;
  };
  // Of the points found before a column and a row; one line of missing points around those found
  // may belong to a marker.
  const int begin = std::max(kExtent - reach_ - 1, 0);
  const int end = std::min(kExtent + reach_ + 2, kCells);
  int found_before[kCells + 1][kCells + 1] = {};
  for (int j = begin; j < end; ++j) {
    for (int i = begin, row = 0; i < end; ++i) {
      row += found_[static_cast<size_t>(j)][static_cast<size_t>(i)] >= 0;
      found_before[j + 1][i + 1] = found_before[j][i + 1] + row;
    }
  }
  const auto sum = [&](int i, int j) { return found_before[j][i]; };
  bool is_full = false;
  for (const Family& family : families_) {
    const int n = family.n();
    const int most = 2 + n * n / 4;  // the baseline node stands for two cells
    std::array<Place, kBlocksPerFamily> best;
    size_t count = 0;
    for (int j = begin; j + n <= end; ++j) {
      for (int i = begin; i + n <= end; ++i) {
        const int missing = n * n - (sum(i + n, j + n) - sum(i, j + n) - sum(i + n, j) + sum(i, j));
        if (missing > most || (count == kBlocksPerFamily && missing >= best[count - 1].missing)) {
          continue;
        }
        count = std::min(count + 1, kBlocksPerFamily);
        size_t k = count - 1;
        for (; k > 0 && best[k - 1].missing > missing; --k) best[k] = best[k - 1];
        best[k] = {missing, i, j};
      }
    }
    is_full |= n > 3 && count > 0 && best[0].missing <= 1;
    for (size_t k = 0; k < count; ++k) {
      const Point2 first = lattice.At(best[k].i - kExtent, best[k].j - kExtent);
      if (!HasGaps({first, lattice.a, lattice.b}, n)) continue;
      const auto full = [this](double place) { return (place + 0.5) * scale_ - 0.5; };
      const FarBlock block{family,
                           {full(first.x), full(first.y)},
                           {lattice.a.x * scale_, lattice.a.y * scale_},
                           {lattice.b.x * scale_, lattice.b.y * scale_},
                           best[k].missing};
      const bool is_new = std::none_of(blocks->begin(), blocks->end(), [&](const FarBlock& other) {
        const Point2 p = block.Center(), q = other.Center();
        return other.family == family && std::abs(p.x - q.x) + std::abs(p.y - q.y) < kSameCenter &&
               std::abs(block.a.x - other.a.x) + std::abs(block.a.y - other.a.y) < kSameStep &&
               std::abs(block.b.x - other.b.x) + std::abs(block.b.y - other.b.y) < kSameStep;
      });
      if (is_new) blocks->push_back(block);
    }
  }
  return is_full;
}

bool FarLattice::IsDone(Point2 place, const std::vector<FarDone>& done) const {
  const double x = (place.x + 0.5) * scale_ - 0.5;
  const double y = (place.y + 0.5) * scale_ - 0.5;
  return std::any_of(done.begin(), done.end(), [&](const FarDone& d) {
    return (d.center.x - x) * (d.center.x - x) + (d.center.y - y) * (d.center.y - y) <
           d.squared_radius;
  });
}

int FarLattice::Search(int column, int row, const std::vector<FarDone>& done,
                       std::vector<FarBlock>* blocks) {
  int grown = 0;
  blocks->clear();
  Collect(column, row, kNear);
  const auto is_seed = [&](int spot, Lattice* lattice) {
    return !used_[static_cast<size_t>(spot)] && !IsDone(place_[static_cast<size_t>(spot)], done) &&
           FindBasis(spot, lattice);
  };
  const Tile& tile = tiles_[static_cast<size_t>(row * tile_cols_ + column)];
  const int end = tile.first + tile.count;
  for (int seed = tile.first; seed < end; ++seed) {
    Lattice lattice;
    if (!is_seed(seed, &lattice)) continue;
    // Of a strongly tilted marker the shortest vectors are a side and the diagonal.
    const Point2 a = lattice.a, b = lattice.b;
    const Lattice variants[] = {lattice,
                                {lattice.origin, b, {b.x - a.x, b.y - a.y}},
                                {lattice.origin, b, {b.x + a.x, b.y + a.y}}};
    for (Lattice variant : variants) {
      if (Cross(variant.a, variant.b) < 0) std::swap(variant.a, variant.b);
      if (!IsPlausible(variant.a, variant.b) || !StandsOut(variant)) continue;
      Collect(column, row, kFar);
      ++grown;
      if (!Grow(seed, &variant) || !AddBlocks(variant, blocks)) continue;
      for (const auto& line : found_) {
        for (const int32_t spot : line) {
          if (spot >= 0) used_[static_cast<size_t>(spot)] = true;
        }
      }
    }
  }
  return grown;
}

}  // namespace topotag
