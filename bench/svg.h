#ifndef TOPOTAG_BENCH_SVG_H_
#define TOPOTAG_BENCH_SVG_H_

#include <string>
#include <vector>

namespace topotag::bench {

/// A quantity on an axis.
struct Axis {
  std::string title;  ///< with its unit
  bool log = false;
};

/// One bar of parts laid end to end.
struct Bar {
  std::string label;
  std::vector<double> parts;
  std::string value;  ///< written at its end
};

/// A row of bars from the same start, one for each series; 0 = no bar.
struct BarGroup {
  std::string label;
  std::vector<double> values;
};

struct Line {
  std::string label;
  std::vector<double> x, y;
  bool dashed = false;
};

/// Plots as inline SVG with their axes; the legend of series is HTML above them. Without data: "".
/// @param series  names of the parts of each bar.
std::string StackedBars(const Axis& axis, const std::vector<std::string>& series,
                        const std::vector<Bar>& bars);
std::string GroupedBars(const Axis& axis, const std::vector<std::string>& series,
                        const std::vector<BarGroup>& groups);
std::string LinePlot(const Axis& x, const Axis& y, const std::vector<Line>& lines);

/// The colours of series 0, 1, .., as in the plots.
std::string Legend(const std::vector<std::string>& series);

/// Three significant digits, without an exponent: "0.123", "12.3", "1230".
std::string ShortNumber(double value);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_SVG_H_
