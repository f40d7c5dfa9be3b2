#ifndef TOPOTAG_BENCH_PROFILE_SECTIONS_H_
#define TOPOTAG_BENCH_PROFILE_SECTIONS_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/scenes.h"
#include "bench/timing.h"

namespace topotag::bench {

using Json = nlohmann::ordered_json;

/// How much a profile measures.
struct Effort {
  std::vector<FrameSize> sizes;        ///< of stages and of the comparison
  std::vector<FrameSize> pixel_sizes;  ///< of the plot of time against pixels
  std::vector<int> marker_counts;      ///< of the plot of time against markers
  Budget stage;                        ///< of each setup, scene and memory
  size_t cold_bytes;                   ///< of the copies in rotation
  double comparison_seconds;           ///< of each scene and number of threads
  int comparison_rounds;               ///< at least
  double throughput_seconds;           ///< of each measurement
  int opencl_starts;                   ///< processes, with each state of the caches
};

Effort FullEffort();
/// Small frames and few of them: whether everything runs, not how fast.
Effort QuickEffort();

/// What there is to measure.
struct Subject {
  Setups setups;
  Photos photos;
  Effort effort;
};

/// The sections of the profile, each an array of measurements. Times are in microseconds, as
/// {"min", "median", "p99"}. Each prints on stderr what it is at.
///
/// Stages: {"size", "pixels", "scene", "memory", "backend", "kind", "threads", "frames", "markers",
/// "expected", "bytes_per_second", "stage_us"}.
Json MeasureStages(const Subject& subject);
/// Whole detections of ours and the peers, in turn: {"size", "pixels", "scene", "threads",
/// "systems": [{"name", "kind", "ours", "threads", "expected", "found", "wrong", "frames", "us"}]}.
Json MeasurePeers(const Subject& subject);
/// The same against the pixels, of 20 markers on a wall; peers on one thread.
Json MeasurePixels(const Subject& subject);
/// The same against the number of markers, at 1280 x 960.
Json MeasureMarkers(const Subject& subject);
/// One detector on one thread against two on two: {"size", "scene", "backend", "kind",
/// "one_fps", "two_fps"}.
Json MeasureThroughput(const Subject& subject);
/// Construction of an opencl detector and its first frame in a new process, with empty and with
/// filled caches of compiled kernels: {"cache", "construct_us", "first_frame_us"}.
/// @param program  this executable, which TimeOpenClStart runs in.
Json MeasureOpenClStart(const Subject& subject, const std::string& program);

/// The work of one such process; prints one line of JSON on standard output.
void TimeOpenClStart();

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_PROFILE_SECTIONS_H_
