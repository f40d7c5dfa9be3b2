// The whole dictionary of a family: the code of every ID, as the bits of the marker's nodes, and
// back. Paper: 4.1 s for the 8,388,608 codes of 5x5.

#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

#include "topotag/marker.h"

namespace topotag {
namespace {

void Dictionary(benchmark::State& state) {
  const Family family(static_cast<int>(state.range(0)));
  std::vector<uint32_t> codes(family.size());
  for (auto _ : state) {
    for (uint64_t id = 0; id < family.size(); ++id) {
      codes[id] = static_cast<uint32_t>(VertexBits(family, id));
    }
    benchmark::ClobberMemory();
    uint64_t wrong = 0;
    for (uint64_t id = 0; id < family.size(); ++id) {
      wrong += IdFromVertexBits(family, codes[id]) != id;
    }
    if (wrong != 0) state.SkipWithError("a code does not give its ID back");
  }
  state.counters["codes"] = static_cast<double>(family.size());
}
BENCHMARK(Dictionary)->DenseRange(3, 5)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace topotag
