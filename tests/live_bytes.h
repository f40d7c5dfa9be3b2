#ifndef TOPOTAG_TESTS_LIVE_BYTES_H_
#define TOPOTAG_TESTS_LIVE_BYTES_H_

// Counts the bytes that the program which includes it has allocated with operator new, in one
// source file.

#include <malloc.h>

#include <atomic>
#include <cstdint>

#include "tests/allocation_hooks.h"

namespace allocation_internal {

inline std::atomic<int64_t> live_bytes{0};
inline std::atomic<int64_t> most_live_bytes{0};

}  // namespace allocation_internal

void OnAllocate(void* memory) {
  using allocation_internal::most_live_bytes;
  const int64_t live = allocation_internal::live_bytes +=
      static_cast<int64_t>(malloc_usable_size(memory));
  int64_t most = most_live_bytes;
  while (most < live && !most_live_bytes.compare_exchange_weak(most, live)) {
  }
}
void OnFree(void* memory) {
  allocation_internal::live_bytes -= static_cast<int64_t>(malloc_usable_size(memory));
}

namespace topotag {

/// The most bytes that were allocated at a time since this was made, beyond those that were then.
/// One at a time.
class PeakBytes {
 public:
  PeakBytes() { allocation_internal::most_live_bytes = before_; }
  int64_t Get() const { return allocation_internal::most_live_bytes - before_; }

 private:
  const int64_t before_ = allocation_internal::live_bytes;
};

}  // namespace topotag

#endif  // TOPOTAG_TESTS_LIVE_BYTES_H_
