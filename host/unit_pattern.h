#ifndef TOPOTAG_HOST_UNIT_PATTERN_H_
#define TOPOTAG_HOST_UNIT_PATTERN_H_

#include <array>
#include <cstdint>

#include "topotag/family.h"
#include "topotag/geometry.h"
#include "topotag/marker.h"

namespace topotag {

struct PhotometricCells;

/// What of a marker's surroundings is taken for known.
enum class KnownOutline {
  kNone,   ///< nothing beyond the gap around the nodes
  kWhite,  ///< the square white area, and black around it
  kPaper,  ///< the square white area, and one grey level around it
  kFrame,  ///< the white area, a frame 1 unit wide, and one grey level around it
};

/// A marker as unit cells. Cell (i, j) has its centre at (i, j) units: nodes lie at even numbers,
/// so that all edges lie between cells. Nodes that are not squares are left out of them.
class UnitPattern {
 public:
  /// @param hidden  bits of the ID whose nodes the image does not show: no pixels near them count
  UnitPattern(Family family, uint64_t id, uint64_t hidden, InnerShape shape, KnownOutline outline);

  int n() const { return n_; }
  InnerShape shape() const { return shape_; }
  KnownOutline surroundings() const { return surroundings_; }
  /// Half the side of the area whose pixels may be used, units.
  double reach() const { return reach_; }
  /// What the cells show to pixels that see so many lines on each axis, within the reach.
  void FillCells(int lines, PhotometricCells* cells) const;
  /// The vertex, from 2 on, whose hole fills the cell (i, j); -1 where there is none.
  int HoleAt(int i, int j) const;
  /// Cells are known for -kHalf <= i, j <= kHalf.
  static constexpr int kHalf = 2 * Family::kMaxN + 5;

 private:
  template <int kLines>
  void FillWindows(PhotometricCells* cells) const;

  int n_;
  uint64_t bits_;
  InnerShape shape_;
  KnownOutline surroundings_;
  double reach_;

  // Bit i + kHalf of row j + kHalf: whether cell (i, j) is black, background, near a hidden node.
  std::array<uint64_t, 2 * kHalf + 1> black_{}, background_{}, unused_{};
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_UNIT_PATTERN_H_
