#ifndef TOPOTAG_HOST_SECOND_LOOK_H_
#define TOPOTAG_HOST_SECOND_LOOK_H_

#include <cstdint>

namespace topotag {

/// Pixels around a white area that is looked at again.
inline constexpr int kSecondLookMargin = 8;
/// All second looks of a frame together cover at most this part of it, 1 / share, and those into
/// the shade as much as the frame: this bounds their time.
inline constexpr int64_t kSecondLookShare = 4;
inline constexpr int64_t kShadeShare = 1;

}  // namespace topotag

#endif  // TOPOTAG_HOST_SECOND_LOOK_H_
