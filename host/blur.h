#ifndef TOPOTAG_HOST_BLUR_H_
#define TOPOTAG_HOST_BLUR_H_

namespace topotag {

/// Of the standard normal distribution, from tables with an error below 2 % of a value + 1e-4:
/// its tail beyond z >= 0, and the integral of its tail from z on.
double NormalTail(double z);
double NormalTailIntegral(double z);

/// Grey levels of a marker that blur acts on, means over its nodes.
struct BlurredLevels {
  double hole;    ///< at the vertices with holes
  double black;   ///< at the others; without such, of the bodies around the holes
  bool solid;     ///< whether there are others
  double gap;     ///< on the outlines of NodeLevels::white
  double corner;  ///< where the nodes have corners if they are square
};

/// Pixels that a unit spans across, of the nodes' mean.
struct UnitHeights {
  double u, v;  ///< between its sides
  double area;  ///< of the unit
};

/// What a marker's holes, gaps and corners say.
struct Blur {
  double variance;         ///< of point spread function and pixel along one axis, square pixels
  double white, contrast;  ///< without blur, grey levels
  double squareness;       ///< of the nodes: 0 for round ones .. 1 for square ones
};

/// The Gaussian blur that leaves holes of 1 unit, relative to gaps of 1 unit, as bright as they
/// are; up to 0.7 units wide.
/// @param levels  black < hole < gap; bilinear between pixels
Blur FindBlur(const BlurredLevels& levels, const UnitHeights& height);

}  // namespace topotag

#endif  // TOPOTAG_HOST_BLUR_H_
