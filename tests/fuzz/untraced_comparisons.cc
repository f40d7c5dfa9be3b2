// In place of libFuzzer's own, by the linker's --wrap: what it would learn from comparisons, values
// that an input has to contain, a picture does not have; keeping them takes a quarter of the time.

#include <cstdint>

#define TOPOTAG_UNTRACED extern "C" __attribute__((no_sanitize("coverage"))) void

// NOLINTBEGIN(bugprone-reserved-identifier): the linker's names.
TOPOTAG_UNTRACED __wrap___sanitizer_cov_trace_cmp4(uint32_t, uint32_t) {}
TOPOTAG_UNTRACED __wrap___sanitizer_cov_trace_cmp8(uint64_t, uint64_t) {}
TOPOTAG_UNTRACED __wrap___sanitizer_cov_trace_const_cmp4(uint32_t, uint32_t) {}
TOPOTAG_UNTRACED __wrap___sanitizer_cov_trace_const_cmp8(uint64_t, uint64_t) {}
// NOLINTEND(bugprone-reserved-identifier)
