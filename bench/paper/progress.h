#ifndef TOPOTAG_BENCH_PAPER_PROGRESS_H_
#define TOPOTAG_BENCH_PAPER_PROGRESS_H_

#include <chrono>
#include <mutex>
#include <string>

namespace topotag::bench::paper {

/// One line on stderr that is rewritten in place: the section, the share of the whole run that is
/// done, time left. Silent where stderr is no terminal. Thread-safe.
class Progress {
 public:
  /// @param total_cost  of all sections that will run, in any unit.
  explicit Progress(double total_cost);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// The next section begins; the one before is done.
  void Begin(const std::string& title, double cost);
  /// How many steps the section has in all; to be called once, before the first of them.
  void SetSteps(int steps);
  void Step();

 private:
  using Clock = std::chrono::steady_clock;

  void Print(bool always);

  std::mutex mutex_;
  bool enabled_;
  double total_cost_;
  double finished_cost_ = 0;
  double cost_ = 0;
  std::string title_;
  int steps_ = 0;
  int done_ = 0;
  Clock::time_point start_ = Clock::now();
  Clock::time_point printed_{};
};

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_PROGRESS_H_
