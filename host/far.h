#ifndef TOPOTAG_HOST_FAR_H_
#define TOPOTAG_HOST_FAR_H_

#include <array>
#include <cstdint>
#include <vector>

#include "host/far_fit.h"
#include "host/far_lattice.h"
#include "host/far_template.h"
#include "host/pipeline.h"
#include "topotag/family.h"

namespace topotag {

/// A marker that was read by the matched filters.
struct FarMarker {
  Family family{Family::kMinN};
  FarReading reading;
};

/// Reads markers whose holes and gaps the bit image does not resolve.
class FarSearch {
 public:
  /// @param min_size  mean side of the white area of a marker, pixels: what seems smaller is left
  ///                  out
  explicit FarSearch(const std::vector<Family>& families, double min_size = 0);

  /// Begins with the part `whole` of a frame.
  /// @param grid  its threshold map: tiles without contrast are passed over
  void Start(const Rect& whole, const ThresholdGrid& grid);
  /// Passes over what lies in a marker that is known.
  /// @param corners  of its white area, pixels of the frame
  void Exclude(const std::array<Point2, 4>& corners);
  /// Whether a place, pixels of the frame, is in the middle of what was excluded.
  bool IsKnown(Point2 place) const;
  /// Looks for markers that fill a quadrilateral, too: clockwise, pixels of the frame.
  void AddQuad(const Point2 quad[4]);
  /// Whether anything is left to look at.
  bool IsNeeded() const;
  /// What Run reads, pixels of the frame.
  Rect Area() const;
  /// @param image  the frame
  /// @return the markers found, the likeliest first
  const std::vector<FarMarker>& Run(const ImageView& image, const Camera* camera);

  /// What is done in vain in a frame, so that texture costs a bounded time: tiles, lattices and
  /// blocks at each of both resolutions, fits.
  static constexpr int kMaxSearched = 200;
  static constexpr int kMaxGrown = 160;
  static constexpr int kMaxBlocks = 120;
  static constexpr int kMaxFits = 16;

  /// Of the last frame.
  struct Counts {
    int tiles = 0, searched = 0, blocks = 0, matched = 0, fits = 0;
  };
  const Counts& counts() const { return counts_; }

 private:
  struct Guess {
    double score;
    Family family;
    Point2 center;
    Point2 corners[4];  ///< of the white area, clockwise from p1's on, pixels of the frame
  };

  /// The white area of a marker that was read: a square of 2 * half units.
  struct WhiteArea {
    Homography to_tag;  ///< from points without the lens
    double half;
  };

  struct TilePlace {
    int column, row;
  };

  void CountSpots(const ImageView& image);
  void SearchScale(const ImageView& image, int scale);
  bool MatchBlocks(const ImageView& image);
  bool IsSparse() const;
  bool IsCrowded(int row, int column, int scale) const;
  void FitGuesses(const ImageView& image, const Camera* camera);
  bool IsRead(Point2 pixel, const Camera* camera) const;
  bool IsTried(const Guess& guess) const;
  double AddGuess(const ImageView& image, Family family, const Point2 corners[4]);
  bool ToGuess(const Guess& guess, const Camera* camera, FarGuess* result) const;

  std::vector<Family> families_;
  double min_size_;
  FarLattice lattice_;
  FarTemplate template_;
  FarFit fit_;
  Rect whole_;
  int tile_cols_ = 0, tile_rows_ = 0;
  std::vector<uint8_t> active_;      ///< of each tile
  std::vector<uint8_t> row_active_;  ///< of each row of tiles, whether there is one
  /// Spots of each tile, at full and at half the resolution: of every second, fourth row.
  std::vector<uint8_t> spots_[2];
  std::vector<uint8_t> bits_;       ///< spots of one row
  std::vector<uint64_t> sums_;      ///< of a row of tiles, four to a word
  std::vector<TilePlace> crowded_;  ///< tiles at one resolution
  std::vector<FarDone> done_;
  std::vector<std::array<Point2, 4>> quads_;
  std::vector<FarBlock> blocks_;
  std::vector<Guess> guesses_, tried_;
  std::vector<FarMarker> markers_;
  std::vector<WhiteArea> read_;  ///< of the markers
  Counts counts_;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_FAR_H_
