#ifndef TOPOTAG_BENCH_TIMING_H_
#define TOPOTAG_BENCH_TIMING_H_

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "topotag/detector.h"

namespace topotag::bench {

/// A stage's name in every output, and its time.
struct Stage {
  const char* name;
  double StageTimes::*time;
};

/// In the order of the pipeline, the whole detection last.
inline constexpr std::array<Stage, 8> kStages{{{"threshold", &StageTimes::threshold},
                                               {"binarize", &StageTimes::binarize},
                                               {"label", &StageTimes::label},
                                               {"tree", &StageTimes::tree},
                                               {"decode", &StageTimes::decode},
                                               {"vertices", &StageTimes::vertices},
                                               {"pose", &StageTimes::pose},
                                               {"total", &StageTimes::total}}};
inline constexpr size_t kTotal = kStages.size() - 1;

/// Of many times, in their unit.
struct Spread {
  double min = 0;
  double median = 0;
  double p99 = 0;  ///< the time that at most 1 % of all exceed
};

/// All 0 without values.
Spread SpreadOf(std::vector<double> values);

/// A backend with a number of threads that this build and machine have.
struct Setup {
  BackendKind backend = BackendKind::kAuto;
  int threads = 1;
  std::string name;  ///< with target or device: "simd/AVX2"
};

struct Setups {
  std::vector<Setup> available;      ///< scalar first, each with ascending threads
  std::vector<std::string> missing;  ///< "opencl: the reason"
};

/// Every backend with each number of threads; scalar with one only. Backends and devices that
/// this build or machine does not have are listed as missing.
Setups FindSetups(const std::vector<int>& threads);

/// How often a setup is measured: until `seconds` have passed, within these numbers of frames.
struct Budget {
  double seconds = 0.5;
  size_t min_frames = 10;
  size_t max_frames = 2000;
};

struct Measured {
  Setup setup;
  size_t frames = 0;
  std::array<Spread, kStages.size()> stages{};  ///< microseconds
  size_t markers = 0;                           ///< found in the last frame
};

/// Times every setup on the same frames, which are used in rotation. The setups take turns in
/// short batches, so that a disturbance of the machine meets all of them; the first frame of a
/// batch is not counted, because it pays for what the others did to the caches.
/// @param options  everything but backend and threads.
/// @throws Error as Detector.
std::vector<Measured> Measure(const std::vector<Setup>& setups, const Options& options,
                              const std::vector<ImageView>& frames, const Budget& budget);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_TIMING_H_
