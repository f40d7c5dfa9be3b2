#ifndef TOPOTAG_HOST_FAR_FIT_H_
#define TOPOTAG_HOST_FAR_FIT_H_

#include <array>
#include <cstdint>

#include "host/buffer.h"
#include "host/far_model.h"
#include "host/homography.h"
#include "topotag/geometry.h"
#include "topotag/image.h"

namespace topotag {

/// Where a marker may be.
struct FarGuess {
  Family family{Family::kMinN};
  Homography map;  ///< tag units to ideal pixels
};

using Matrix8 = std::array<std::array<double, 8>, 8>;

/// A marker read from grey levels.
struct FarReading {
  uint64_t bits = 0;       ///< bit i: of model vertex i
  Homography map;          ///< tag units to ideal pixels
  double margin = 0;       ///< log-likelihood of the bits less that of the next best ones, nats
  double correlation = 0;  ///< of the model with the image
  double min_step = 0;     ///< smallest rise of a flipped bit's residual, in an ideal hole's
  double black = 0, white = 0;  ///< grey levels
  double blur = 0;              ///< standard deviation, pixels
  /// Of the parameters of the inverse map (pixels from `origin` to units) row by row.
  Homography inverse;
  Point2 origin;
  Matrix8 covariance{};
};

/// Matched filters on the grey levels: fits the model of a blurred marker to its image.
///
/// Unknown are the map, the blur, the levels of white, nodes, frame and what lies beyond each side,
/// and one amplitude a node for its hole: Gauss-Newton on all of them at once, the map affine at
/// first. Then each bit is the nearer of no hole and an ideal hole, and a homography is fitted with
/// the bits fixed, while flipping one of them improves the fit.
class FarFit {
 public:
  /// @param whole  what may be read of the image
  /// @return false where the model does not describe the image.
  bool Run(const ImageView& image, const Camera* camera, const Rect& whole, const FarGuess& guess,
           FarReading* reading);

 private:
  /// Of the dense part: levels (white, nodes, frame), blur, sides (4), map (8), gain (2, to 4).
  static constexpr int kDense = 20;
  static constexpr int kBlur = 3;
  static constexpr int kSides = 4;
  static constexpr int kMap = 8;
  static constexpr int kGain = 16;
  static constexpr int kMaxUnknowns = kDense + kMaxVertices;
  /// Of the model's standard deviations, while bits are sought and afterwards.
  static constexpr double kCoarse = 0.06, kFine = 0.01;
  static constexpr double kStartBlur = 0.75;        ///< pixels
  static constexpr double kEarlyCorrelation = 0.7;  ///< after two steps
  static constexpr double kBeyondWhite = 0.5;       ///< how far pixels are used, units

  struct Pixel {
    float x, y;  ///< ideal pixels from the origin
    float grey;
  };

  struct Stats {
    int count = 0;
    double residual = 0;  ///< sum of squares
    double correlation = 0;
  };

  bool Gather(const ImageView& image, const Camera* camera, const Rect& whole,
              const FarGuess& guess);
  bool SetModel(double tolerance);
  bool ChooseShape();
  void Accumulate(bool holes_free);
  void AddPriors(bool affine);
  bool Solve(bool affine);
  void Move(bool holes_free);
  double Variance() const;
  bool DecideBits();
  bool TestFlips(FarReading* reading, bool* flipped);
  bool IsPartOfLarger() const;
  bool AreHolesLocal();
  bool Store(FarReading* reading);
  double& Normal(int row, int column) { return normal_[row * stride_ + column]; }
  int Vertex(int column, int row) const;

  Family family_{Family::kMinN};
  Point2 origin_;
  Jacobian2 lens_{1, 0, 0, 1};  ///< ideal pixels per pixel
  Buffer<Pixel> pixels_;
  size_t pixel_count_ = 0;
  FarModel model_;
  FarModel::Shape shape_{};

  // The unknowns.
  double map_[8];  ///< of the inverse homography, row by row
  double blur_ = 0;
  FarLevels levels_;
  double gain_[2];            ///< change of all levels per unit of u and v, in parts of them
  float hole_[kMaxVertices];  ///< amplitude of each vertex's hole
  uint64_t bits_ = 0;

  Stats stats_;
  int stride_ = 0;                              ///< unknowns of the system
  double normal_[kMaxUnknowns * kMaxUnknowns];  ///< lower triangle, row-major
  double gradient_[kMaxUnknowns];
  float flip_square_[kMaxVertices], flip_product_[kMaxVertices];
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_FAR_FIT_H_
