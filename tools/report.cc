#include "tools/report.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "tools/report_formats.h"

namespace topotag::tools {

// Adding 0 turns -0 into 0.
double RoundTo(double value, double scale) { return std::round(value * scale) / scale + 0.0; }

double Pixels(double value) { return RoundTo(value, 1e6); }

double Significant(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", value);
  return std::strtod(text, nullptr) + 0.0;
}

std::string IdText(const Detection& detection) {
  if (detection.unknown_bits == 0) return std::to_string(detection.id);
  std::string code;
  for (int bit = detection.family.bits() - 1; bit >= 0; --bit) {
    code += (detection.unknown_bits >> bit & 1) != 0 ? '?'
            : (detection.id >> bit & 1) != 0         ? '1'
                                                     : '0';
  }
  return code;
}

std::string FormatHeader(Format format, const ExtraColumns& columns) {
  return format == Format::kCsv ? CsvHeader(columns) : "";
}

std::string FormatFrame(Format format, const ExtraColumns& columns, const FrameResult& result) {
  switch (format) {
    case Format::kJson:
      return FormatJson(columns, result);
    case Format::kCsv:
      return FormatCsv(columns, result);
    default:
      return FormatText(columns, result);
  }
}

}  // namespace topotag::tools
