#ifndef TOPOTAG_HOST_AREA_RASTER_H_
#define TOPOTAG_HOST_AREA_RASTER_H_

#include <cstddef>
#include <vector>

#include "topotag/geometry.h"

namespace topotag {

/// A pixel's response to light: the pixel's square convolved with a Gaussian. Both factors are
/// separable, so the response of a whole polygon reduces to an integral along its edges of
/// products of two one-dimensional functions, which are tabulated here.
class PixelResponse {
 public:
  /// Below this, blur changes no pixel by more than a thousandth of the contrast.
  static constexpr double kNegligibleSigma = 0.002;

  /// @param sigma of the Gaussian, pixels, >= 0; below kNegligibleSigma it counts as 0.
  explicit PixelResponse(double sigma);

  bool blurred() const { return sigma_ > 0; }
  double sigma() const { return sigma_; }
  /// No light from beyond this distance (per axis) reaches a pixel's centre, pixels.
  double reach() const { return reach_; }

  /// Pixels that an edge point at `position` influences, first + 0 .. weights.size() - 1.
  /// Profile: response of each pixel to a point of light. Step: by how much its response to the
  /// half line beyond the point exceeds its left neighbour's. Each sums to 1. Only where blurred.
  int Profile(double position, std::vector<double>* weights) const;
  int Step(double position, std::vector<double>* weights) const;

 private:
  struct Table {
    int taps = 0;
    std::vector<double> rows;  // (intervals + 1) x taps, one row a fractional position
  };

  void Fill(Table* table, bool step) const;
  int LookUp(const Table& table, double position, std::vector<double>* weights) const;

  double sigma_;
  double reach_;
  int radius_ = 0;     // reach, rounded up to whole pixels
  int intervals_ = 0;  // fractional positions in a table
  Table profile_;
  Table step_;
};

/// Sums weighted polygons over a rectangle of pixels. The value of a pixel is the integral of
/// weight times the pixel's response over each polygon: exact area coverage without blur, and
/// within 2e-6 of the weight with it (no sampling grid is involved; tests/renderer_test.cc).
/// Polygons may reach beyond the rectangle on all sides.
class AreaRaster {
 public:
  /// Pixels x0 .. x0 + width - 1, y0 .. y0 + height - 1; all 0. Keeps a reference to `response`.
  AreaRaster(const PixelResponse& response, const Rect& area);

  /// Adds a simple polygon (either orientation), in pixels, before Finish.
  void Add(const std::vector<Point2>& polygon, double weight);
  /// Turns the sums into pixel values; call once, after the last Add.
  void Finish();
  /// Row y (absolute) of the finished values, `width` of them.
  const double* row(int y) const;

 private:
  double* MutableRow(int y) { return cells_.data() + static_cast<size_t>(y) * stride_; }
  void AddEdge(Point2 a, Point2 b, double weight);
  void AddPiece(Point2 a, Point2 b, double weight);
  void AddBlurred(Point2 a, Point2 b, double weight);
  void AddPoint(Point2 p, double weight);
  void AddExact(Point2 a, Point2 b, double weight);
  void AddSpan(int y, double from, double to, double weight);

  const PixelResponse& response_;
  Rect area_;
  size_t stride_;
  std::vector<double> cells_;  // differences along each row until Finish
  std::vector<double> columns_, rows_;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_AREA_RASTER_H_
