#ifndef TOPOTAG_HOST_PLACE_GRID_H_
#define TOPOTAG_HOST_PLACE_GRID_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "topotag/geometry.h"

namespace topotag {

/// Places in a frame, sorted into square cells, so that what is near to one is found without a
/// look at all of them: a frame may hold ten thousand markers.
class PlaceGrid {
 public:
  /// Empty, for a frame of this size. Places outside of it count for the cells at its border.
  void Start(int width, int height) {
    cols_ = (width - 1) / kCell + 1;
    rows_ = (height - 1) / kCell + 1;
    first_.assign(static_cast<size_t>(cols_) * static_cast<size_t>(rows_), kNone);
    places_.clear();
  }

  void Add(Point2 place) {
    uint32_t& first = first_[Cell(Index(place.x, cols_), Index(place.y, rows_))];
    places_.push_back({place, first});
    first = static_cast<uint32_t>(places_.size() - 1);
  }

  /// Whether one is nearer than that; never for what is no number.
  bool HasNear(Point2 place, double squared_distance) const {
    const double reach = std::sqrt(squared_distance);
    const int x1 = Index(place.x + reach, cols_), y1 = Index(place.y + reach, rows_);
    for (int y = Index(place.y - reach, rows_); y <= y1; ++y) {
      for (int x = Index(place.x - reach, cols_); x <= x1; ++x) {
        for (uint32_t i = first_[Cell(x, y)]; i != kNone; i = places_[i].next) {
          const double dx = places_[i].place.x - place.x, dy = places_[i].place.y - place.y;
          if (dx * dx + dy * dy < squared_distance) return true;
        }
      }
    }
    return false;
  }

 private:
  static constexpr int kCell = 64;  // pixels
  static constexpr uint32_t kNone = UINT32_MAX;
  struct Entry {
    Point2 place;
    uint32_t next;  ///< in the same cell
  };

  static int Index(double coordinate, int count) {
    const double cell = coordinate / kCell;
    return cell > 0 ? static_cast<int>(std::min(cell, count - 1.0)) : 0;
  }
  size_t Cell(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(cols_) + static_cast<size_t>(x);
  }

  int cols_ = 0, rows_ = 0;
  std::vector<uint32_t> first_;  ///< of each cell
  std::vector<Entry> places_;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_PLACE_GRID_H_
