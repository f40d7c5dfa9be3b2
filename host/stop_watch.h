#ifndef TOPOTAG_HOST_STOP_WATCH_H_
#define TOPOTAG_HOST_STOP_WATCH_H_

#include <chrono>

namespace topotag {

class StopWatch {
 public:
  /// Microseconds since construction or the last call.
  double Lap() {
    const auto now = Clock::now();
    const std::chrono::duration<double, std::micro> lap = now - last_;
    last_ = now;
    return lap.count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_STOP_WATCH_H_
