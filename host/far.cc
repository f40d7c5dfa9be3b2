#include "host/far.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "host/far_spots.h"
#include "host/mean_side.h"

namespace topotag {
namespace {

// Which tiles are searched: a spot has this depth, grey levels; a tile has one, and with three of
// its neighbours this many, at full and at half the resolution, in the rows that are looked at.
struct Gate {
  int depth;
  int around[2];
};
constexpr Gate kGate = {22, {5, 18}};
// Where so few tiles have contrast that all of them may be searched.
constexpr Gate kWideGate = {10, {3, 8}};
constexpr int kFewTiles = 100;
constexpr double kMinMatch = 0.6;  // correlation with the template
constexpr double kGoodMatch = 0.85;
constexpr double kSameGuess = 0.25;  // pitches, between corners
constexpr double kLarger = 0.05;

ImageView CropTo(const ImageView& image, const Rect& area) {
  return {image.row(area.y) + area.x, area.width, area.height, image.stride};
}

// Set bits of each 16 bits.
uint64_t CountOfTiles(uint64_t bits) {
  bits -= bits >> 1 & 0x5555555555555555;
  bits = (bits & 0x3333333333333333) + (bits >> 2 & 0x3333333333333333);
  bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0f;
  return (bits + (bits >> 8)) & 0x00ff00ff00ff00ff;
}

}  // namespace

FarSearch::FarSearch(const std::vector<Family>& families, double min_size)
    : families_(families), min_size_(min_size), lattice_(families, min_size), template_(families) {}

void FarSearch::Start(const Rect& whole, const ThresholdGrid& grid) {
  whole_ = whole;
  tile_cols_ = grid.cols - 1;
  tile_rows_ = grid.rows - 1;
  active_.resize(grid.floor.size());
  for (size_t i = 0; i < active_.size(); ++i) {
    active_[i] = grid.floor[i] == 0 && grid.ceiling[i] == 255;
  }
  counts_ = {};
  row_active_.resize(static_cast<size_t>(tile_rows_));
  for (int r = 0; r < tile_rows_; ++r) {
    const uint8_t* row = active_.data() + static_cast<size_t>(r) * static_cast<size_t>(tile_cols_);
    int count = 0;
    for (int c = 0; c < tile_cols_; ++c) count += row[c];
    row_active_[static_cast<size_t>(r)] = count > 0;
    counts_.tiles += count;
  }
  guesses_.clear();
  tried_.clear();
  done_.clear();
  quads_.clear();
  markers_.clear();
  read_.clear();
}

void FarSearch::Exclude(const std::array<Point2, 4>& corners) {
  double x0 = INFINITY, y0 = INFINITY, x1 = -INFINITY, y1 = -INFINITY;
  FarDone done{{0, 0}, INFINITY};
  for (size_t i = 0; i < 4; ++i) {
    const Point2& corner = corners[i];
    const double dx = corners[(i + 1) % 4].x - corner.x, dy = corners[(i + 1) % 4].y - corner.y;
    done.center.x += (corner.x - whole_.x) / 4;
    done.center.y += (corner.y - whole_.y) / 4;
    done.squared_radius = std::min(done.squared_radius, 0.36 * (dx * dx + dy * dy));
    x0 = std::min(x0, corner.x - whole_.x), x1 = std::max(x1, corner.x - whole_.x);
    y0 = std::min(y0, corner.y - whole_.y), y1 = std::max(y1, corner.y - whole_.y);
  }
  done_.push_back(done);
  const auto clamp = [](double tile, int count) {
    return static_cast<int>(std::clamp(tile, -1.0, static_cast<double>(count)));
  };
  for (int r = std::max(clamp(y0 / kTile, tile_rows_), 0);
       r <= std::min(clamp(y1 / kTile, tile_rows_), tile_rows_ - 1); ++r) {
    for (int c = std::max(clamp(x0 / kTile, tile_cols_), 0);
         c <= std::min(clamp(x1 / kTile, tile_cols_), tile_cols_ - 1); ++c) {
      const Point2 p{whole_.x + kTile * (c + 0.5), whole_.y + kTile * (r + 0.5)};
      bool inside = true;
      for (size_t i = 0; i < 4; ++i) {
        const Point2& a = corners[i];
        const Point2& b = corners[(i + 1) % 4];
        inside &= (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0;
      }
      uint8_t& active = active_[static_cast<size_t>(r * tile_cols_ + c)];
      if (!inside || active == 0) continue;
      active = 0;
      --counts_.tiles;
    }
  }
}

// At half the resolution the spots' surroundings are twice as far away.
void FarSearch::CountSpots(const ImageView& image) {
  const Gate& gate = IsSparse() ? kWideGate : kGate;
  for (std::vector<uint8_t>& counts : spots_) counts.assign(active_.size(), 0);
  bits_.resize(static_cast<size_t>(tile_cols_) * (kTile / 8) + 64);
  sums_.resize(static_cast<size_t>(tile_cols_) / 4 + 1);
  for (int r = 0; r < tile_rows_; ++r) {
    if (row_active_[static_cast<size_t>(r)] == 0) continue;
    const int y_end = std::min((r + 1) * kTile, image.height);
    const size_t first = static_cast<size_t>(r * tile_cols_);
    for (int c = 0; c < tile_cols_;) {
      if (active_[first + static_cast<size_t>(c)] == 0) {
        ++c;
        continue;
      }
      const int begin = c;
      while (c < tile_cols_ && active_[first + static_cast<size_t>(c)] != 0) ++c;
      for (int scale = lattice_.MinScale(); scale <= 2; ++scale) {
        uint8_t* count = spots_[scale - 1].data() + first;
        for (int y = r * kTile; y < y_end; y += 2 * scale) {
          FindSpots(image, y, begin * kTile, std::min(c * kTile, image.width), scale, gate.depth,
                    bits_.data());
          for (int group = begin / 4; group <= (c - 1) / 4; ++group) {
            uint64_t bits;
            std::memcpy(&bits, bits_.data() + 8 * group, sizeof(bits));
            const auto k = static_cast<size_t>(group);
            sums_[k] = (y == r * kTile ? 0 : sums_[k]) + CountOfTiles(bits);
          }
        }
        for (int k = begin; k < c; ++k) {
          count[k] = static_cast<uint8_t>(sums_[static_cast<size_t>(k / 4)] >> (16 * (k % 4)));
        }
      }
    }
  }
}

// Whether a tile at a scale and those around it have spots enough.
bool FarSearch::IsCrowded(int row, int column, int scale) const {
  const Gate& gate = IsSparse() ? kWideGate : kGate;
  const std::vector<uint8_t>& spots = spots_[scale - 1];
  const auto at = [&](int r, int c) {
    int sum = 0;
    for (int y = r * scale; y < std::min((r + 1) * scale, tile_rows_); ++y) {
      for (int x = c * scale; x < std::min((c + 1) * scale, tile_cols_); ++x) {
        sum += spots[static_cast<size_t>(y * tile_cols_ + x)];
      }
    }
    return sum;
  };
  const int own = at(row, column);
  if (own == 0) return false;
  const int rows = (tile_rows_ + scale - 1) / scale, cols = (tile_cols_ + scale - 1) / scale;
  int most = 0;
  for (int dr = -1; dr <= 1; dr += 2) {
    for (int dc = -1; dc <= 1; dc += 2) {
      const bool has_row = row + dr >= 0 && row + dr < rows;
      const bool has_column = column + dc >= 0 && column + dc < cols;
      most = std::max(most, own + (has_row ? at(row + dr, column) : 0) +
                                (has_column ? at(row, column + dc) : 0) +
                                (has_row && has_column ? at(row + dr, column + dc) : 0));
    }
  }
  return most >= gate.around[scale - 1];
}

void FarSearch::SearchScale(const ImageView& image, int scale) {
  if (image.width < 2 * kTile || image.height < 2 * kTile) return;
  crowded_.clear();
  for (int r = 0; r * scale < tile_rows_; ++r) {
    const int last_row = std::min((r + 1) * scale, tile_rows_);
    if (std::none_of(row_active_.begin() + r * scale, row_active_.begin() + last_row,
                     [](uint8_t active) { return active != 0; })) {
      continue;
    }
    for (int c = 0; c * scale < tile_cols_; ++c) {
      if (scale == 1 && spots_[0][static_cast<size_t>(r * tile_cols_ + c)] == 0) continue;
      if (IsCrowded(r, c, scale)) crowded_.push_back({c, r});
    }
  }
  if (crowded_.empty()) return;
  lattice_.SetImage(image, scale);
  int searched = 0, grown = 0, matched = 0;  // in vain
  for (const int weight : FarLattice::kCenterWeights) {
    lattice_.SetSmoothing(weight);
    for (const TilePlace& tile : crowded_) {
      if (searched == kMaxSearched || grown >= kMaxGrown || matched >= kMaxBlocks) return;
      ++counts_.searched;
      const int tile_grown = lattice_.Search(tile.column, tile.row, done_, &blocks_);
      counts_.blocks += static_cast<int>(blocks_.size());
      if (MatchBlocks(image)) continue;
      ++searched;
      grown += tile_grown;
      matched += static_cast<int>(blocks_.size());
    }
  }
}

// Whether one is likely to be a marker.
bool FarSearch::MatchBlocks(const ImageView& image) {
  bool is_good = false;
  for (const FarBlock& block : blocks_) {
    // The white area reaches five eighths of a pitch beyond the first and the last node.
    const double begin = -0.625, end = block.family.n() - 0.375;
    const auto at = [&block](double i, double k) {
      return Point2{block.first.x + i * block.a.x + k * block.b.x,
                    block.first.y + i * block.a.y + k * block.b.y};
    };
    const Point2 corners[4] = {at(begin, begin), at(end, begin), at(end, end), at(begin, end)};
    if (AddGuess(image, block.family, corners) < kGoodMatch) continue;
    const double half = block.family.n() / 2.0 - 0.25;
    const double squared = std::min(block.a.x * block.a.x + block.a.y * block.a.y,
                                    block.b.x * block.b.x + block.b.y * block.b.y);
    done_.push_back({block.Center(), half * half * squared});
    is_good = true;
  }
  return is_good;
}

// Keeps what looks like a marker; returns how much it does.
double FarSearch::AddGuess(const ImageView& image, Family family, const Point2 corners[4]) {
  Homography map;
  if (MeanSide(corners) < min_size_ || !SquareToQuad(family.white_side() / 2.0, corners, &map)) {
    return 0;
  }
  int turns = 0;
  const double score = template_.Match(image, family, map, &turns);
  if (score < kMinMatch) return score;
  const Point2 center = map.Map({0, 0});
  Guess guess{score, family, {center.x + whole_.x, center.y + whole_.y}, {}};
  for (int i = 0; i < 4; ++i) {
    const Point2& corner = corners[(i + turns) % 4];
    guess.corners[i] = {corner.x + whole_.x, corner.y + whole_.y};
  }
  guesses_.push_back(guess);
  return score;
}

bool FarSearch::IsKnown(Point2 place) const {
  return std::any_of(done_.begin(), done_.end(), [&](const FarDone& done) {
    const double dx = done.center.x + whole_.x - place.x;
    const double dy = done.center.y + whole_.y - place.y;
    return dx * dx + dy * dy < done.squared_radius;
  });
}

void FarSearch::AddQuad(const Point2 quad[4]) {
  quads_.push_back({quad[0], quad[1], quad[2], quad[3]});
}

bool FarSearch::ToGuess(const Guess& guess, const Camera* camera, FarGuess* result) const {
  Point2 quad[4];
  for (int i = 0; i < 4; ++i) {
    if (!PixelToIdeal(camera, guess.corners[i], &quad[i])) return false;
  }
  result->family = guess.family;
  return SquareToQuad(guess.family.white_side() / 2.0, quad, &result->map);
}

bool FarSearch::IsNeeded() const { return counts_.tiles > 0 || !quads_.empty(); }

bool FarSearch::IsSparse() const { return counts_.tiles <= kFewTiles; }

Rect FarSearch::Area() const { return whole_; }

const std::vector<FarMarker>& FarSearch::Run(const ImageView& image, const Camera* camera) {
  if (!IsNeeded()) return markers_;
  const ImageView full = CropTo(image, whole_);
  CountSpots(full);
  for (int scale = lattice_.MinScale(); scale <= 2; ++scale) SearchScale(full, scale);
  for (const std::array<Point2, 4>& quad : quads_) {
    Point2 corners[4];
    for (size_t i = 0; i < 4; ++i) corners[i] = {quad[i].x - whole_.x, quad[i].y - whole_.y};
    for (const Family& family : families_) AddGuess(full, family, corners);
  }
  counts_.matched = static_cast<int>(guesses_.size());
  std::sort(guesses_.begin(), guesses_.end(), [](const Guess& a, const Guess& b) {
    // A part of a larger marker looks like a smaller one.
    const double sa = a.score + kLarger * a.family.n();
    const double sb = b.score + kLarger * b.family.n();
    if (sa != sb) return sa > sb;
    if (a.center.y != b.center.y) return a.center.y < b.center.y;
    return a.center.x < b.center.x;
  });
  FitGuesses(image, camera);
  return markers_;
}

// Whether a pixel lies in a marker that was read.
bool FarSearch::IsRead(Point2 pixel, const Camera* camera) const {
  Point2 ideal;
  if (!PixelToIdeal(camera, pixel, &ideal)) return true;
  return std::any_of(read_.begin(), read_.end(), [&](const WhiteArea& white) {
    const Point2 tag = white.to_tag.Map(ideal);
    return std::abs(tag.x) < white.half && std::abs(tag.y) < white.half;
  });
}

// Whether a fit from nearly the same place was in vain.
bool FarSearch::IsTried(const Guess& guess) const {
  return std::any_of(tried_.begin(), tried_.end(), [&](const Guess& other) {
    if (!(other.family == guess.family)) return false;
    const Point2* p = guess.corners;
    const double area =
        std::abs((p[2].x - p[0].x) * (p[3].y - p[1].y) - (p[2].y - p[0].y) * (p[3].x - p[1].x)) / 2;
    const double limit = kSameGuess / guess.family.n() * std::sqrt(area);
    for (int i = 0; i < 4; ++i) {
      const double dx = p[i].x - other.corners[i].x, dy = p[i].y - other.corners[i].y;
      if (dx * dx + dy * dy > limit * limit) return false;
    }
    return true;
  });
}

void FarSearch::FitGuesses(const ImageView& image, const Camera* camera) {
  for (const Guess& guess : guesses_) {
    if (counts_.fits == kMaxFits + static_cast<int>(markers_.size())) break;
    if (IsRead(guess.center, camera) || IsTried(guess)) continue;
    FarGuess start;
    if (!ToGuess(guess, camera, &start)) continue;
    ++counts_.fits;
    FarMarker marker;
    marker.family = guess.family;
    if (fit_.Run(image, camera, whole_, start, &marker.reading)) {
      markers_.push_back(marker);
      WhiteArea white{{}, marker.family.white_side() / 2.0};
      if (Invert(marker.reading.map, &white.to_tag)) read_.push_back(white);
    } else {
      tried_.push_back(guess);
    }
  }
}

}  // namespace topotag
