#ifndef TOPOTAG_BENCH_PAPER_PAGE_H_
#define TOPOTAG_BENCH_PAPER_PAGE_H_

#include <string>
#include <vector>

#include "bench/paper/section.h"

namespace topotag::bench::paper {

/// What the page says of the run as a whole.
struct RunFacts {
  Json machine;  ///< of DescribeMachine
  std::string backgrounds;
  std::vector<std::string> systems;  ///< "name: description"
  std::vector<std::string> missing;  ///< peers that the build lacks, with the reason
  double seconds = 0;
  bool quick = false;
};

/// One self-contained HTML page.
std::string MakePage(const RunFacts& facts, const std::vector<Section>& sections);

/// The same figures.
Json MakeJson(const RunFacts& facts, const std::vector<Section>& sections);

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_PAGE_H_
