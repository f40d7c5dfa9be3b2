#ifndef TOPOTAG_HOST_FAR_TEMPLATE_H_
#define TOPOTAG_HOST_FAR_TEMPLATE_H_

#include <array>
#include <vector>

#include "host/homography.h"
#include "topotag/family.h"
#include "topotag/image.h"

namespace topotag {

/// What a blurred marker looks like before its ID is known: one sample a unit over its white area,
/// every hole at one half.
class FarTemplate {
 public:
  explicit FarTemplate(const std::vector<Family>& families);

  /// Correlation of the image with the marker in the best of its four rotations.
  /// @param map    tag units to pixels, if the marker is not turned; affine near the marker's
  /// centre
  /// @param turns  by how many quarter turns it is: its x axis is that of the map turned clockwise
  /// @return 0 where the white area is not all in the image
  double Match(const ImageView& image, Family family, const Homography& map, int* turns) const;

  static constexpr int kMaxSide = 4 * Family::kMaxN + 1;

 private:
  static constexpr int kBlurs = 4;
  /// Of one blur, mean 0 and norm 1, row-major.
  using Samples = std::vector<float>;

  std::array<std::array<Samples, kBlurs>, Family::kMaxN + 1> samples_;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_FAR_TEMPLATE_H_
