#ifndef TOPOTAG_BENCH_MACHINE_H_
#define TOPOTAG_BENCH_MACHINE_H_

#include <nlohmann/json.hpp>

namespace topotag::bench {

/// What the figures depend on: processor, cores, caches, system, compiler, date, version.
/// Unknown values are left out.
nlohmann::ordered_json DescribeMachine();

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_MACHINE_H_
