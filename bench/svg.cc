#include "bench/svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "bench/html.h"

namespace topotag::bench {
namespace {

constexpr std::array<const char*, 10> kColors{"#3b6fb6", "#e08a2e", "#3f9e5b", "#c4474b",
                                              "#8564b8", "#5fb3c4", "#8c6a50", "#d877b0",
                                              "#7b8794", "#b8b02c"};

const char* Color(size_t i) { return kColors[i % kColors.size()]; }

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

std::string Text(double x, double y, const char* anchor, const std::string& text,
                 const char* more = "") {
  return "<text x='" + Number(x) + "' y='" + Number(y) + "' text-anchor='" + anchor + "'" + more +
         ">" + Escape(text) + "</text>";
}

std::string Segment(double x0, double y0, double x1, double y1, const char* css) {
  return "<line x1='" + Number(x0) + "' y1='" + Number(y0) + "' x2='" + Number(x1) + "' y2='" +
         Number(y1) + "' class='" + css + "'/>";
}

std::string Box(double x, double y, double width, double height, size_t color,
                const std::string& tip) {
  return "<rect x='" + Number(x) + "' y='" + Number(y) + "' width='" + Number(width) +
         "' height='" + Number(height) + "' fill='" + Color(color) + "'><title>" + Escape(tip) +
         "</title></rect>";
}

std::string Svg(double width, double height, const std::string& content) {
  return "<svg viewBox='0 0 " + Number(width) + " " + Number(height) + "' width='" + Number(width) +
         "' role='img'>" + content + "</svg>";
}

/// Maps values to a stretch of pixels.
class Scale {
 public:
  Scale(const Axis& axis, double low, double high, double from, double to)
      : log_(axis.log), from_(from), to_(to) {
    if (log_) {
      MakeLogTicks(low, high);
    } else {
      MakeTicks(std::min(low, 0.0), high);
    }
  }

  double operator()(double value) const {
    const double share =
        (Transform(value) - Transform(low_)) / (Transform(high_) - Transform(low_));
    return from_ + std::clamp(share, 0.0, 1.0) * (to_ - from_);
  }
  const std::vector<double>& ticks() const { return ticks_; }

 private:
  double Transform(double value) const { return log_ ? std::log10(value) : value; }

  void MakeTicks(double low, double high) {
    const double raw = std::max(high - low, 1e-9) / 5;
    const double decade = std::pow(10, std::floor(std::log10(raw)));
    const double lead = raw / decade;
    const double step = decade * (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10);
    low_ = std::floor(low / step) * step;
    high_ = std::ceil(high / step - 1e-9) * step;
    for (int i = 0; low_ + i * step < high_ + step / 2; ++i) ticks_.push_back(low_ + i * step);
  }

  void MakeLogTicks(double low, double high) {
    const auto next = [](double tick) {
      const double lead = tick / std::pow(10, std::floor(std::log10(tick) + 1e-9));
      return tick * (lead < 1.5 ? 2 : lead < 3 ? 2.5 : 2);
    };
    double tick = std::pow(10, std::floor(std::log10(low)));
    while (next(tick) <= low * (1 + 1e-9)) tick = next(tick);
    for (; tick < high; tick = next(tick)) ticks_.push_back(tick);
    ticks_.push_back(tick);
    low_ = ticks_.front();
    high_ = ticks_.back();
    if (ticks_.size() <= 8) return;
    // Powers of ten only.
    const auto odd = [](double t) {
      return std::abs(std::log10(t) - std::round(std::log10(t))) > 1e-6;
    };
    ticks_.erase(std::remove_if(ticks_.begin(), ticks_.end(), odd), ticks_.end());
  }

  bool log_;
  double from_, to_;
  double low_ = 0, high_ = 1;
  std::vector<double> ticks_;
};

constexpr double kBarHeight = 16;

/// The grid of a plot of horizontal bars, the axis below it.
std::string BarGrid(const Axis& axis, const Scale& scale, double left, double right,
                    double height) {
  std::string out;
  for (const double tick : scale.ticks()) {
    out += Segment(scale(tick), 0, scale(tick), height, "rule");
    out += Text(scale(tick), height + 14, "middle", ShortNumber(tick));
  }
  if (!axis.log) out += Segment(left, 0, left, height, "axis");
  out += Text((left + right) / 2, height + 30, "middle", axis.title, " class='title'");
  return out;
}

}  // namespace

std::string ShortNumber(double value) {
  if (value == 0) return "0";
  const int before = static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;
  const int digits = std::clamp(3 - before, 0, 6);
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  std::string out = text;
  if (out.find('.') != std::string::npos) {
    while (out.back() == '0') out.pop_back();
    if (out.back() == '.') out.pop_back();
  }
  return out;
}

std::string Legend(const std::vector<std::string>& series) {
  std::string out = "<div class='legend'>";
  for (size_t i = 0; i < series.size(); ++i) {
    out += std::string("<span><i style='background:") + Color(i) + "'></i>" + Escape(series[i]) +
           "</span>";
  }
  return out + "</div>\n";
}

std::string StackedBars(const Axis& axis, const std::vector<std::string>& series,
                        const std::vector<Bar>& bars) {
  constexpr double kLeft = 100, kRight = 385, kWidth = 500, kPitch = 22;
  double high = 0;
  for (const Bar& bar : bars) {
    double sum = 0;
    for (const double part : bar.parts) sum += part;
    high = std::max(high, sum);
  }
  if (high <= 0) return "";
  const Scale scale(axis, 0, high, kLeft, kRight);
  const double height = kPitch * static_cast<double>(bars.size());
  std::string out = BarGrid(axis, scale, kLeft, kRight, height);
  for (size_t i = 0; i < bars.size(); ++i) {
    const double y = kPitch * static_cast<double>(i) + (kPitch - kBarHeight) / 2;
    out += Text(kLeft - 6, y + 12, "end", bars[i].label);
    double sum = 0;
    for (size_t p = 0; p < bars[i].parts.size(); ++p) {
      const double from = scale(sum);
      sum += bars[i].parts[p];
      out += Box(from, y, scale(sum) - from, kBarHeight, p,
                 series[p] + ": " + ShortNumber(bars[i].parts[p]));
    }
    out += Text(scale(sum) + 5, y + 12, "start", bars[i].value);
  }
  return Svg(kWidth, height + 36, out);
}

std::string GroupedBars(const Axis& axis, const std::vector<std::string>& series,
                        const std::vector<BarGroup>& groups) {
  constexpr double kLeft = 170, kRight = 430, kWidth = 500, kGap = 12;
  double low = 1e300, high = 0;
  for (const BarGroup& group : groups) {
    for (const double value : group.values) {
      if (value > 0) low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (high <= 0) return "";
  const Scale scale(axis, axis.log ? std::min(low, 1.0) : 0, high, kLeft, kRight);
  std::string bars;
  double y = kGap / 2;
  for (const BarGroup& group : groups) {
    const double top = y;
    for (size_t i = 0; i < group.values.size(); ++i) {
      if (group.values[i] <= 0) continue;
      // On a logarithmic axis bars start at 1, to either side.
      const double start = axis.log ? scale(1) : kLeft, end = scale(group.values[i]);
      bars += Box(std::min(start, end), y, std::abs(end - start), kBarHeight - 2, i,
                  series[i] + ": " + ShortNumber(group.values[i]));
      bars += Text(std::max(start, end) + 5, y + 11, "start", ShortNumber(group.values[i]));
      y += kBarHeight;
    }
    bars += Text(kLeft - 6, (top + y) / 2 + 3, "end", group.label);
    y += kGap;
  }
  const double height = y - kGap / 2;
  if (axis.log) bars += Segment(scale(1), 0, scale(1), height, "axis");
  return Svg(kWidth, height + 36, BarGrid(axis, scale, kLeft, kRight, height) + bars);
}

std::string LinePlot(const Axis& x_axis, const Axis& y_axis, const std::vector<Line>& lines) {
  constexpr double kLeft = 58, kRight = 505, kTop = 8, kBottom = 320, kWidth = 520;
  double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300;
  for (const Line& line : lines) {
    for (const double x : line.x) x0 = std::min(x0, x), x1 = std::max(x1, x);
    for (const double y : line.y) y0 = std::min(y0, y), y1 = std::max(y1, y);
  }
  if (x1 < x0) return "";
  const Scale x(x_axis, x0, x1, kLeft, kRight), y(y_axis, y0, y1, kBottom, kTop);
  std::string out;
  for (const double tick : x.ticks()) {
    out += Segment(x(tick), kTop, x(tick), kBottom, "rule");
    out += Text(x(tick), kBottom + 15, "middle", ShortNumber(tick));
  }
  for (const double tick : y.ticks()) {
    out += Segment(kLeft, y(tick), kRight, y(tick), "rule");
    out += Text(kLeft - 6, y(tick) + 4, "end", ShortNumber(tick));
  }
  out += Segment(kLeft, kBottom, kRight, kBottom, "axis");
  out += Segment(kLeft, kTop, kLeft, kBottom, "axis");
  out += Text((kLeft + kRight) / 2, kBottom + 32, "middle", x_axis.title, " class='title'");
  out += Text(0, 0, "middle", y_axis.title,
              " class='title' transform='translate(12 164) rotate(-90)'");
  for (size_t i = 0; i < lines.size(); ++i) {
    std::string points, dots;
    for (size_t k = 0; k < lines[i].x.size(); ++k) {
      const std::string at_x = Number(x(lines[i].x[k])), at_y = Number(y(lines[i].y[k]));
      points.append(at_x).append(",").append(at_y).append(" ");
      dots.append("<circle cx='").append(at_x).append("' cy='").append(at_y);
      dots.append("' r='3' fill='").append(Color(i)).append("'><title>");
      dots.append(Escape(lines[i].label + ": " + ShortNumber(lines[i].y[k])));
      dots.append("</title></circle>");
    }
    out += "<polyline points='" + points + "' fill='none' stroke='" + Color(i) +
           "' stroke-width='2'" + (lines[i].dashed ? " stroke-dasharray='6 4'" : "") + "/>" + dots;
  }
  return Svg(kWidth, kBottom + 38, out);
}

}  // namespace topotag::bench
