#ifndef TOPOTAG_TESTS_THREAD_TIME_H_
#define TOPOTAG_TESTS_THREAD_TIME_H_

#include <time.h>

namespace topotag {

/// Processor time of the calling thread, seconds: others on the machine do not count in.
inline double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

}  // namespace topotag

#endif  // TOPOTAG_TESTS_THREAD_TIME_H_
