#ifndef TOPOTAG_HOST_PHOTOMETRIC_MODEL_H_
#define TOPOTAG_HOST_PHOTOMETRIC_MODEL_H_

#include <array>
#include <cstddef>

#include "host/buffer.h"
#include "topotag/marker.h"

namespace topotag {

/// The unknowns of a photometric fit, in the order of its equations. Lengths in units of the tag.
/// The pose changes to R exp(w), t + R tau.
enum PhotometricUnknown {
  kTauX,
  kTauY,
  kTauZ,
  kOmegaX,
  kOmegaY,
  kOmegaZ,
  kBlack,
  kWhite,
  kGainX,  ///< growth of all levels but the background's along u, a unit
  kGainY,
  kBlurXx,  ///< covariance of the point spread function, pixel included, square pixels
  kBlurXy,
  kBlurYy,
  kGrowth,  ///< by which every black area is larger on each side than designed, units
  kBackground,
  kPhotometricUnknowns
};

inline constexpr size_t kPhotometricSums =
    kPhotometricUnknowns * (kPhotometricUnknowns + 1) / 2 + kPhotometricUnknowns + 1;

/// Index of entry (i, j), i <= j, of the upper triangle of the normal matrix, which comes first.
constexpr size_t TriangleIndex(size_t i, size_t j) {
  return i * kPhotometricUnknowns - i * (i - 1) / 2 + (j - i);
}

/// Pixels that are computed together, whatever the vector: results do not depend on its width.
inline constexpr size_t kPixelLanes = 16;

/// About so many pixels are used of one marker, at most: of larger ones, a regular part.
inline constexpr int kMaxPhotometricPixels = 8192;

/// Lines between unit cells, on either axis, that shape a pixel: the nearest ones, an even number.
inline constexpr int kFewLines = 2;
inline constexpr int kManyLines = 4;

/// What is known of each pixel before the fit, kPixelLanes values each.
enum PixelField {
  kPixelX,  ///< ideal pixel, from the centre of the fit
  kPixelY,
  kPixelLevel,
  kPixelWeight,  ///< 1; 0 fills up the last block
  kPixelU,       ///< centre of the unit cell that the pixel lies in
  kPixelV,
  kPixelFlags,       ///< of the cell, 32-bit integers, CellFlag
  kPixelBlack,       ///< bits of the cells of the window, a row after the other: black ones
  kPixelBackground,  ///< those of the background
  kPixelLensXx,      ///< derivatives of the ideal pixel by the pixel
  kPixelLensXy,
  kPixelLensYx,
  kPixelLensYy,
  kPixelFields
};

/// Of nodes that are not squares, whose edges therefore are none of the unit cells': centres of a
/// pixel's own node and of the one beyond the gap; 1 where the former has a hole, the latter is.
enum NodeField { kOwnU, kOwnV, kOwnHole, kNextU, kNextV, kNextNode, kNodeFields };

inline constexpr int kMaxPhotometricOrder = 10;

/// Blocks of pixels: first those that see black and white only, then those that see the background
/// as well.
struct PixelBlocks {
  int lines = kFewLines;
  int hole_blocks = 0;    ///< first ones in which holes that are not squares are seen
  bool sees_next = true;  ///< the node beyond the gap, where nodes are not squares
  int inner_blocks = 0;
  int blocks = 0;
  int order = 2;  ///< of the expansion in the correlation of the axes, 2 .. kMaxPhotometricOrder
  bool has_lens = false;
  InnerShape shape = InnerShape::kSquare;
  Buffer<float> fields;  ///< of each block; then its nodes' fields unless they are squares

  /// Room for all pixels of any marker, once: memory that is not written costs nothing.
  void Reserve() {
    constexpr size_t kBlocks = 6 * kMaxPhotometricPixels / kPixelLanes + 3;
    fields.Reserve(kBlocks * (kPixelFields + kNodeFields) * kPixelLanes);
  }
  /// From block to block.
  size_t Stride() const {
    return (kPixelFields + (shape == InnerShape::kSquare ? 0 : static_cast<size_t>(kNodeFields))) *
           kPixelLanes;
  }
  const float* block(int index) const {
    return fields.data() + static_cast<size_t>(index) * Stride();
  }
};

/// The model at the current values of the unknowns.
struct PhotometricModel {
  /// Tag point of an ideal pixel (x, y): u = (u . (1, x, y)) / (w . (1, x, y)), v alike.
  std::array<float, 3> u, v, w;
  /// The tag's normal in the basis of its axes and the view's: the inverse of (R e1, R e2, t) times
  /// R e3. Turns the depth of a tag point into its shift on the plane.
  std::array<float, 3> normal;
  float black, white, gain_x, gain_y, blur_xx, blur_xy, blur_yy, growth, background;
  float huber;  ///< residuals beyond this count linearly, grey levels
};

/// Sums over all pixels: the normal matrix' upper triangle by TriangleIndex, the gradient J'r, and
/// the cost, the sum of Huber's function (r^2 where it is small).
using PhotometricSums = std::array<double, kPhotometricSums>;
inline constexpr size_t kGradientSums = kPhotometricSums - kPhotometricUnknowns - 1;
inline constexpr size_t kCostSum = kPhotometricSums - 1;

/// Evaluates the model at all pixels.
///
/// The marker is a pattern of unit cells. The image of a line between two cells, blurred, is a
/// normal distribution function in tag coordinates; where two lines cross, the two are correlated,
/// because the map from the pixels shears: the product of the two becomes the series of products
/// of their derivatives times rho^k / k! (Mehler).
/// Highway kernel: the same operations in every lane of every target, no fused ones.
/// @param step  of the blocks that are evaluated: all, or every so many
/// @param residuals  model minus image, grey levels, of the blocks that are evaluated
void EvaluatePhotometric(const PixelBlocks& pixels, const PhotometricModel& model, int step,
                         PhotometricSums* sums, float* residuals);

}  // namespace topotag

#endif  // TOPOTAG_HOST_PHOTOMETRIC_MODEL_H_
