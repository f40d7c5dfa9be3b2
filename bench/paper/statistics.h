#ifndef TOPOTAG_BENCH_PAPER_STATISTICS_H_
#define TOPOTAG_BENCH_PAPER_STATISTICS_H_

#include <optional>
#include <string>
#include <vector>

#include "bench/paper/section.h"
#include "topotag/detection.h"
#include "topotag/renderer.h"

namespace topotag::bench::paper {

/// How far a pose is from the truth, or from another pose.
struct PoseDifference {
  double position = 0;  ///< millimetres
  double rotation = 0;  ///< degrees
};

PoseDifference Difference(const PoseSolution& pose, const Matrix3& R, const Vector3& t);

/// Mean and largest of some values.
struct MeanMax {
  int count = 0;
  double mean = 0;
  double max = 0;
};

MeanMax MeanMaxOf(const std::vector<double>& values);

/// Root mean square distance of poses from their mean: what is seen of a marker that rests.
/// Nothing for fewer than two.
std::optional<PoseDifference> JitterOf(const std::vector<PoseSolution>& poses);
/// The same of points that are seen again and again: [frame][point], over all points, pixels.
std::optional<double> JitterOf(const std::vector<std::vector<Point2>>& frames);

/// A value with three significant digits, but at most four decimals.
Cell Significant(std::optional<double> value);

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_STATISTICS_H_
