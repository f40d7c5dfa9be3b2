#ifndef TOPOTAG_HOST_FAR_LATTICE_H_
#define TOPOTAG_HOST_FAR_LATTICE_H_

#include <array>
#include <cstdint>
#include <vector>

#include "host/buffer.h"
#include "host/pipeline.h"
#include "topotag/family.h"
#include "topotag/geometry.h"
#include "topotag/image.h"

namespace topotag {

/// A square block of a lattice of dark spots: the node in row r and column c is near
/// first + c a + r b, det(a, b) > 0; or the block is turned by quarter turns.
struct FarBlock {
  Family family{Family::kMinN};
  Point2 first, a, b;  ///< pixels
  int missing = 0;     ///< cells without a spot

  Point2 Center() const {
    const double half = (family.n() - 1) / 2.0;
    return {first.x + half * (a.x + b.x), first.y + half * (a.y + b.y)};
  }
};

/// A place that needs no further search.
struct FarDone {
  Point2 center;
  double squared_radius;
};

/// Finds lattices in the dark spots of an image. Spots are collected tile by tile, where they are
/// needed, once for each image and smoothing.
class FarLattice {
 public:
  /// Weights of a pixel, to its four neighbours' 1, where the darkest places are looked for: nodes
  /// of which the hole shows need more smoothing than those that are hardly apart.
  static constexpr int kCenterWeights[] = {6, 20};

  /// @param min_size  mean side of the white area of a marker, pixels: lattices in which that of
  /// the
  ///                  largest family is smaller are left out
  FarLattice(std::vector<Family> families, double min_size);

  /// The first scale that is needed: from 6 px of pitch on the second one finds all lattices.
  int MinScale() const;

  /// @param scale  1, or 2: looked at is the image at half the resolution
  void SetImage(const ImageView& image, int scale);
  /// Forgets the spots.
  void SetSmoothing(int center_weight);
  /// Finds the blocks of the lattices that go through a spot in a tile of kTile x kTile pixels.
  /// @param column, row  of the tile, at the scale
  /// @return how many lattices were grown
  int Search(int column, int row, const std::vector<FarDone>& done, std::vector<FarBlock>* blocks);

 private:
  /// Tiles around the one that is searched: what a seed's neighbours need, what a marker needs.
  static constexpr int kNear = 1, kFar = 3;
  static constexpr int kMaxSpots = 1 << 15;
  static constexpr int kExtent = Family::kMaxN - 1;
  static constexpr int kCells = 2 * kExtent + 1;

  /// Where the seed is (0, 0).
  struct Lattice {
    Point2 origin, a, b;
    Point2 At(double i, double j) const {
      return {origin.x + i * a.x + j * b.x, origin.y + i * a.y + j * b.y};
    }
  };

  struct Tile {
    uint32_t pass;     ///< in which its spots were collected
    int first, count;  ///< of place_
  };

  void Collect(int column, int row, int around);
  void CollectTile(int column, int row);
  bool Descend(int x, int y);
  void Halve(int tile_row);
  int Smooth(int x, int y) const;
  double Grey(Point2 p) const;
  int Nearest(Point2 p, double tolerance) const;
  bool FindBasis(int seed, Lattice* lattice) const;
  bool IsPlausible(Point2 a, Point2 b) const;
  int CountAround(const Lattice& lattice, double tolerance, int least) const;
  bool StandsOut(const Lattice& lattice) const;
  bool HasGaps(const Lattice& lattice, int n) const;
  bool Refit(Lattice* lattice) const;
  bool Grow(int seed, Lattice* lattice);
  bool AddBlocks(const Lattice& lattice, std::vector<FarBlock>* blocks) const;
  bool IsDone(Point2 place, const std::vector<FarDone>& done) const;

  std::vector<Family> families_;
  int largest_;       ///< n of the largest family
  double min_steps_;  ///< of |a| + |b|, pixels of the image
  int scale_ = 1;
  int center_weight_ = 0;
  ImageView image_{};  ///< at full resolution
  ImageView view_{};   ///< at the scale
  Buffer<uint8_t> halved_;
  std::vector<uint8_t> is_halved_;  ///< of each row of tiles
  Buffer<uint8_t> bits_;            ///< spots of a row, as FindSpots gives them
  int tile_cols_ = 0, tile_rows_ = 0;
  uint32_t pass_ = 0;
  std::vector<Tile> tiles_;
  int count_ = 0;
  uint32_t before_ = 0;  ///< spots of all passes before
  Buffer<Point2> place_;
  Buffer<bool> used_;
  std::vector<uint32_t> cell_;  ///< of each pixel: before_ + index of its spot + 1, or less
  int reach_ = 0;               ///< of the points found from the seed
  std::array<std::array<int32_t, kCells>, kCells> found_;  ///< spot of a lattice point, or -1
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_FAR_LATTICE_H_
