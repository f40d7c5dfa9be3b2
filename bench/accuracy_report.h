#ifndef TOPOTAG_BENCH_ACCURACY_REPORT_H_
#define TOPOTAG_BENCH_ACCURACY_REPORT_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/accuracy_cells.h"

namespace topotag::bench {

/// All figures of a run.
nlohmann::ordered_json SummarizeAccuracy(const std::vector<AccuracyCell>& cells);

/// The same as tables, with the cells that miss their targets.
std::string AccuracyTables(const nlohmann::ordered_json& summary);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_ACCURACY_REPORT_H_
