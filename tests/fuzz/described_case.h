#ifndef TOPOTAG_TESTS_FUZZ_DESCRIBED_CASE_H_
#define TOPOTAG_TESTS_FUZZ_DESCRIBED_CASE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/random_image.h"
#include "topotag/tracker.h"

namespace topotag::fuzz {

enum class Check { kStages, kDetections, kTracks };

/// A frame of a video: where in it the picture lies, and what else happens.
struct Shot {
  enum class Event { kNone, kNoPicture, kLowerFrame, kReset };

  int x, y;  ///< of the picture's first pixel, always within the frame
  Event event;
};

/// What the bytes of an input describe: what is compared, with which options, and the picture.
struct Case {
  Check check;
  size_t subject;  ///< which target with how many threads is compared with the scalar backend
  bool pipelined;  ///< detections: the detector has two frames at a time
  bool refined;    ///< detections: the first one gets the photometric step on its own
  TrackerOptions options;
  PaddedImage picture;

  // Tracks: the picture moves over a ground of one level.
  int width, height, padding;
  uint8_t ground;
  std::vector<Shot> shots;
};

Case DescribedCase(const uint8_t* data, size_t size);

/// Of a video.
PaddedImage Frame(const Case& video, const Shot& shot);

}  // namespace topotag::fuzz

#endif  // TOPOTAG_TESTS_FUZZ_DESCRIBED_CASE_H_
