#include "host/unit_pattern.h"

#include <algorithm>
#include <cmath>

#include "host/model.h"
#include "host/photometric_scan.h"

namespace topotag {

UnitPattern::UnitPattern(Family family, uint64_t id, uint64_t hidden, InnerShape shape,
                         KnownOutline surroundings)
    : n_(family.n()), bits_(VertexBits(family, id)), shape_(shape), surroundings_(surroundings) {
  const int white = 2 * n_;  // the white area's last cell
  reach_ = white + (surroundings == KnownOutline::kFrame   ? 2.5
                    : surroundings == KnownOutline::kPaper ? 1.5
                    : surroundings == KnownOutline::kWhite ? 1
                                                           : 0.5);
  constexpr uint64_t kAll = (uint64_t{1} << (2 * kHalf + 1)) - 1;
  // Cells -half .. half.
  const auto span = [](int half) { return ((uint64_t{2} << (2 * half)) - 1) << (kHalf - half); };
  for (int j = -kHalf; j <= kHalf; ++j) {
    const auto row = static_cast<size_t>(j + kHalf);
    const uint64_t inside = std::abs(j) <= white ? span(white) : 0;
    const int frame = white + (surroundings == KnownOutline::kFrame ? 1 : 0);
    const uint64_t framed = std::abs(j) <= frame ? span(frame) : 0;
    if (surroundings == KnownOutline::kWhite) black_[row] = kAll & ~inside;
    if (surroundings == KnownOutline::kFrame || surroundings == KnownOutline::kPaper) {
      black_[row] = framed & ~inside;
      background_[row] = kAll & ~framed;
    }
  }
  if (shape == InnerShape::kSquare) {
    const Point2* model = ModelTable(family);
    for (int k = 0; k < family.vertex_count(); ++k) {
      const int x = static_cast<int>(model[k].x) + kHalf, y = static_cast<int>(model[k].y) + kHalf;
      for (int j = y - 1; j <= y + 1; ++j) black_[static_cast<size_t>(j)] |= uint64_t{7} << (x - 1);
    }
    for (int k = 0; k < family.vertex_count(); ++k) {
      if (k >= 2 && (bits_ >> k & 1) == 0) continue;
      const int x = static_cast<int>(model[k].x) + kHalf, y = static_cast<int>(model[k].y) + kHalf;
      black_[static_cast<size_t>(y)] &= ~(uint64_t{1} << x);
    }
  }
  const uint64_t unseen = VertexBits(family, hidden) & ~uint64_t{3};
  for (int k = 2; k < family.vertex_count(); ++k) {
    if ((unseen >> k & 1) == 0) continue;
    const Point2 node = ModelTable(family)[k];
    const int x = static_cast<int>(node.x) + kHalf, y = static_cast<int>(node.y) + kHalf;
    for (int j = y - 2; j <= y + 2; ++j) unused_[static_cast<size_t>(j)] |= uint64_t{31} << (x - 2);
  }
}

template <int kLines>
void UnitPattern::FillWindows(PhotometricCells* cells) const {
  constexpr int around = kLines / 2, side = kLines + 1;
  const int reach = static_cast<int>(reach_ + 0.5);
  const uint64_t row_bits = (uint64_t{1} << side) - 1;
  for (int j = -reach; j <= reach; ++j) {
    const auto y = static_cast<size_t>(j + kHalf);
    const auto differ = [&](uint64_t other_black, uint64_t other_background) {
      return (black_[y] ^ other_black) | (background_[y] ^ other_background);
    };
    const uint64_t left = differ(black_[y] << 1, background_[y] << 1);
    const uint64_t right = differ(black_[y] >> 1, background_[y] >> 1);
    const uint64_t above = differ(black_[y - 1], background_[y - 1]);
    const uint64_t below = differ(black_[y + 1], background_[y + 1]);
    const int first = PhotometricCells::Index(-reach, j);
    for (int i = -reach; i <= reach; ++i) {
      const int bit = i + kHalf;
      const auto window = [&](const std::array<uint64_t, 2 * kHalf + 1>& cells) {
        const uint64_t* row = cells.data() + y - around;
        uint64_t bits = 0;
        for (int q = 0; q < side; ++q) bits |= (row[q] >> (bit - around) & row_bits) << (side * q);
        return bits;
      };
      const uint64_t black = window(black_), background = window(background_);
      const auto at = static_cast<size_t>(first + i + reach);
      uint64_t flags = (left >> bit & 1) * kEdgeLeft | (right >> bit & 1) * kEdgeRight |
                       (above >> bit & 1) * kEdgeAbove | (below >> bit & 1) * kEdgeBelow;
      if (background != 0) flags |= kSeesBackground;
      if ((unused_[y] >> bit & 1) != 0) flags = kNotUsed;
      cells->flags[at] = static_cast<int32_t>(flags);
      cells->black[at] = static_cast<int32_t>(black);
      cells->background[at] = static_cast<int32_t>(background);
    }
  }
  for (int k = 0; k < n_ * n_; ++k) {
    const bool has_hole = (bits_ >> k & 1) != 0;
    cells->holes[static_cast<size_t>(k)] = has_hole ? 1.0f : 0.0f;
    const int first = -2 * (n_ - 1);
    if (k < 2 || !has_hole) continue;
    cells->flags[static_cast<size_t>(
        PhotometricCells::Index(first + k % n_ * 4, first + k / n_ * 4))] |= kInHole;
  }
}

void UnitPattern::FillCells(int lines, PhotometricCells* cells) const {
  if (lines == kFewLines) {
    FillWindows<kFewLines>(cells);
  } else {
    FillWindows<kManyLines>(cells);
  }
}

int UnitPattern::HoleAt(int i, int j) const {
  const int u = i + 2 * (n_ - 1), v = j + 2 * (n_ - 1);
  if (u < 0 || v < 0 || u % 4 != 0 || v % 4 != 0 || u / 4 >= n_ || v / 4 >= n_) return -1;
  const int vertex = v / 4 * n_ + u / 4;
  return vertex >= 2 && (bits_ >> vertex & 1) != 0 ? vertex : -1;
}

}  // namespace topotag
