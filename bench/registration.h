#ifndef TOPOTAG_BENCH_REGISTRATION_H_
#define TOPOTAG_BENCH_REGISTRATION_H_

#include <functional>
#include <string>

namespace topotag::bench {

/// The main function of a benchmark whose scenes may use photographs: takes --photos=DIR or
/// --photos DIR out of the arguments, registers, and leaves the rest to Google Benchmark.
/// @param add  registers the benchmarks, given the folder ("" = none).
/// @return exit status: 0; 1 for an error, printed on stderr; 2 for wrong usage.
int RunBenchmarks(int argc, char** argv, const std::function<void(const std::string& photos)>& add);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_REGISTRATION_H_
