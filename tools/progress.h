#ifndef TOPOTAG_TOOLS_PROGRESS_H_
#define TOPOTAG_TOOLS_PROGRESS_H_

#include <chrono>
#include <cstdint>

namespace topotag::tools {

/// One line on stderr that is rewritten in place: frames done and in all, frames/s, time left.
class Progress {
 public:
  /// @param total  frames in all; 0 = unknown. Silent unless `enabled` and total is not 1.
  Progress(bool enabled, int64_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Step();
  /// Removes the line, so that another one can be printed on the terminal.
  void Clear();

 private:
  using Clock = std::chrono::steady_clock;

  void Print(double seconds) const;

  bool enabled_;
  int64_t total_;
  int64_t done_ = 0;
  bool shown_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_{};
};

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_PROGRESS_H_
