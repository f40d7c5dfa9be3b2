#ifndef TOPOTAG_HOST_FAR_MODEL_H_
#define TOPOTAG_HOST_FAR_MODEL_H_

#include "host/buffer.h"
#include "host/quad.h"
#include "topotag/camera.h"
#include "topotag/family.h"

namespace topotag {

/// What the image of a blurred marker is made of at one tag point: grey level = sum of amplitudes
/// times these. Areas are fractions of the blurred shapes, 0 .. 1.
struct FarBasis {
  float nodes;  ///< all nodes, less the two holes of the baseline node
  float frame;  ///< everything outside the white area
  Quad sides;   ///< beyond the frame: left, right, above, below
  Quad holes;   ///< of the nodes around: (row, column), (row, column + 1), the same in the next row
};

/// The place of the four holes that a point may see, and whether there is a node to be holed.
struct FarCell {
  int column, row;  ///< of the first of them; may be -1
};

/// Amplitudes of a marker's image, grey levels. White is the level of the white area; the others
/// are differences: of the node's black to it, of the frame's, and of what lies beyond the frame to
/// the frame's.
struct FarLevels {
  float white = 0;
  float node = 0;
  float frame = 0;
  Quad sides{};
};

/// The grey level at a tag point with its derivatives.
struct FarSample {
  FarBasis basis;
  float value;
  float u, v;        ///< first derivatives, per unit
  float uu, vv, uv;  ///< second derivatives
};

/// A marker under a Gaussian blur: every edge along an axis of the tag is an error function, and
/// the shapes are products of those of two axes. Where the blur's axes are not the tag's, it is the
/// mean of such products that are shifted along the direction in which both coordinates vary
/// together (Gauss-Hermite quadrature). Circles and hexagons count as squares of nearly the same
/// area and second moments, which at this resolution look alike.
class FarModel {
 public:
  /// Half sides of nodes and holes as squares, in kStep.
  struct Shape {
    int node, hole;
  };
  static constexpr double kStep = 1.0 / 16;  ///< of the tables, units
  static constexpr Shape kSquare{24, 8};
  static constexpr Shape kHexagon{22, 7};
  static constexpr Shape kCircle{21, 7};

  /// @param covariance  of the blur in tag units: xx, xy, yy
  /// @param tolerance   part by which a standard deviation may be off
  void Set(Family family, const Shape& shape, const double covariance[3], double tolerance);
  /// The next Set is exact: what comes does not depend on what was before.
  void Forget() { x_.sigma = y_.sigma = 0; }

  /// Cells whose holes the basis at (u, v) holds.
  FarCell Cell(float u, float v) const;
  /// @param cell   Cell(u, v)
  /// @param holes  amplitudes of its four holes
  void Evaluate(float u, float v, const FarCell& cell, const FarLevels& levels, Quad holes,
                FarSample* sample) const;

 private:
  static constexpr int kMaxShifts = 7;

  /// Four profiles along one axis with their derivatives.
  struct Profile {
    Quad value, slope, curvature;
  };
  struct Entry {
    Profile shapes;  ///< x: nodes, baseline less the nodes it replaces, its holes, white area
                     ///< y: nodes, nodes of the first row, their holes, white area
    Profile sides;   ///< x: left, right, inside, inside; y: 1, 1, above, below
  };
  struct Hole {
    float value, slope, curvature;
  };
  /// Along one axis.
  struct Table {
    float sigma = 0;
    Buffer<Entry> entries;
    Buffer<Hole> hole;  ///< of a cell's hole, from the cell's centre
  };

  void Fill(Table* table, double sigma, double tolerance, bool along_x);
  Entry At(const Table& table, float place) const;
  Profile Holes(const Table& table, float place, int cell, bool along_x) const;

  Family family_{Family::kMinN};
  Shape shape_{0, 0};
  int half_ = 0;  ///< of the tables, in kStep
  Table x_, y_;
  int shifts_ = 1;
  float shift_x_[kMaxShifts], shift_y_[kMaxShifts], weight_[kMaxShifts];
  Buffer<float> step_, density_, slope_;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_FAR_MODEL_H_
