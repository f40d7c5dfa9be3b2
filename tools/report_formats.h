#ifndef TOPOTAG_TOOLS_REPORT_FORMATS_H_
#define TOPOTAG_TOOLS_REPORT_FORMATS_H_

#include <string>

#include "tools/report.h"

// What report.h's formats are made of.

namespace topotag::tools {

/// The lines of one frame.
std::string FormatText(const ExtraColumns& columns, const FrameResult& result);
std::string FormatJson(const ExtraColumns& columns, const FrameResult& result);
std::string FormatCsv(const ExtraColumns& columns, const FrameResult& result);
/// The names of the columns.
std::string CsvHeader(const ExtraColumns& columns);

/// Rounded to a multiple of 1 / scale; 0, never -0.
double RoundTo(double value, double scale);
/// Rounded to 1e-6.
double Pixels(double value);
/// Rounded to 9 significant digits.
double Significant(double value);
/// The ID, or where it is not known its code with a ? for each bit that is hidden.
std::string IdText(const Detection& detection);

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_REPORT_FORMATS_H_
