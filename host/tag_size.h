#ifndef TOPOTAG_HOST_TAG_SIZE_H_
#define TOPOTAG_HOST_TAG_SIZE_H_

namespace topotag {

/// Sides of white areas in metres, between which covariances are finite and not 0.
inline constexpr double kMinTagSize = 1e-9;
inline constexpr double kMaxTagSize = 1e6;

}  // namespace topotag

#endif  // TOPOTAG_HOST_TAG_SIZE_H_
