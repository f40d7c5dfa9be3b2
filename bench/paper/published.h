#ifndef TOPOTAG_BENCH_PAPER_PUBLISHED_H_
#define TOPOTAG_BENCH_PAPER_PUBLISHED_H_

#include <string>
#include <vector>

#include "bench/paper/section.h"

namespace topotag::bench::paper {

/// What the paper says of one system, as text; "" where no source that was read has the figure:
/// published.cc says which those are. Distances in metres, errors in millimetres and degrees,
/// shares in per cent, times in milliseconds on an i7-7700HQ.
struct Published {
  std::string name;  ///< "TopoTag 4x4", "AprilTag-2 36h11"
  std::string dictionary, min_distance, max_distance;
  std::string recall, precision, time;
  std::string false_positives;  ///< on 207,883 photographs (LabelMe)
  std::string position_avg, position_max, rotation_avg, rotation_max;
  std::string position_jitter, rotation_jitter;
  std::string max_occlusion;
};

/// All systems of the paper of which something is known, TopoTag's first.
const std::vector<Published>& PublishedFigures();

/// Rows for a table: systems that have at least one of the members, a cell for each of them.
std::vector<Row> PublishedRows(const std::vector<std::string Published::*>& members);

/// What stands beside figures of the paper's: they were measured with a camera on a robot arm.
inline constexpr char kRobotArm[] =
    "Rows of the paper: measured with a robot arm and printed markers (the paper), not on the "
    "frames of this page.";

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_PUBLISHED_H_
