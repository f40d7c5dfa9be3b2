#ifndef TOPOTAG_HOST_LATTICE_H_
#define TOPOTAG_HOST_LATTICE_H_

#include <array>
#include <cstdint>

#include "host/homography.h"

namespace topotag {

/// A dark spot that may be a node of a grid, or a hole that may be the centre of one.
struct Spot {
  Point2 at;       ///< ideal pixels
  double area;     ///< of the node, holes included, square ideal pixels
  bool is_single;  ///< a node of its own: grids may begin with it
};

inline constexpr int kMaxSpots = 192;

/// What GrowLattice has done with a spot.
enum class SpotUse : uint8_t {
  kFree,
  kTried,  ///< as the first of a grid
  kTaken,  ///< it is in a grid
};

/// Spots on the crossings of a grid in perspective, as far as it goes on from one of them.
struct Lattice {
  struct Cell {
    int spot, col, row;
  };
  static constexpr int kMaxCells = 64;
  static constexpr int kPitch = 4;  ///< units from one crossing to the next

  int count = 0;
  std::array<Cell, kMaxCells> cells;
  int first_col, last_col, first_row, last_row;
  /// Of (kPitch col, kPitch row) to ideal pixels; orientation as on the screen, x to y clockwise.
  Homography map;
};

/// Grows a grid from the spots, those near to `start` first, that are in none yet.
/// Neighbours are found by where the last two crossings, or those beside them, lead.
/// @param use  of each spot; what is tried and taken is noted, so that the next call finds another
/// @return false where there is none with at least 5 crossings, or enough has been tried.
bool GrowLattice(const Spot* spots, int count, Point2 start, SpotUse* use, Lattice* lattice);

}  // namespace topotag

#endif  // TOPOTAG_HOST_LATTICE_H_
