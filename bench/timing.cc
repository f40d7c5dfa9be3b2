#include "bench/timing.h"

#include <algorithm>
#include <cmath>

#include "host/stop_watch.h"

namespace topotag::bench {
namespace {

constexpr size_t kBatch = 8;  // counted frames

Options WithSetup(Options options, const Setup& setup) {
  options.backend = setup.backend;
  options.threads = setup.threads;
  return options;
}

/// One setup with its times so far.
class Runner {
 public:
  Runner(const Setup& setup, const Options& options)
      : setup_(setup), detector_(WithSetup(options, setup)) {}

  void Batch(const std::vector<ImageView>& frames, size_t* next, const Budget& budget) {
    for (size_t i = 0; i <= kBatch && !Done(budget); ++i) {
      detector_.detect(frames[*next], &found_);
      *next = (*next + 1) % frames.size();
      if (i > 0) Add(detector_.times());
    }
  }

  bool Done(const Budget& budget) const {
    const size_t count = times_[kTotal].size();
    return count >= budget.max_frames ||
           (count >= budget.min_frames && spent_ >= 1e6 * budget.seconds);
  }

  Measured Result() const {
    Measured measured;
    measured.setup = setup_;
    measured.frames = times_[kTotal].size();
    for (size_t s = 0; s < kStages.size(); ++s) measured.stages[s] = SpreadOf(times_[s]);
    measured.markers = found_.size();
    return measured;
  }

 private:
  void Add(const StageTimes& times) {
    for (size_t s = 0; s < kStages.size(); ++s) times_[s].push_back(times.*kStages[s].time);
    spent_ += times.total;
  }

  Setup setup_;
  Detector detector_;
  std::vector<Detection> found_;
  std::array<std::vector<double>, kStages.size()> times_;
  double spent_ = 0;  // microseconds
};

}  // namespace

Spread SpreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  const size_t p99 = static_cast<size_t>(std::ceil(0.99 * static_cast<double>(n))) - 1;
  return {values[0], (values[(n - 1) / 2] + values[n / 2]) / 2, values[p99]};
}

Setups FindSetups(const std::vector<int>& threads) {
  Setups setups;
  for (const BackendKind backend :
       {BackendKind::kScalar, BackendKind::kSimd, BackendKind::kOpenCl}) {
    try {
      for (const int count : threads) {
        if (backend == BackendKind::kScalar && count != 1) continue;
        Setup setup{backend, count, ""};
        setup.name = Detector(WithSetup({}, setup)).backend();
        setups.available.push_back(std::move(setup));
      }
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kUnavailable && error.code() != ErrorCode::kDevice) throw;
      setups.missing.push_back(std::string(Name(backend)) + ": " + error.what());
    }
  }
  return setups;
}

std::vector<Measured> Measure(const std::vector<Setup>& setups, const Options& options,
                              const std::vector<ImageView>& frames, const Budget& budget) {
  std::vector<Runner> runners;
  runners.reserve(setups.size());
  for (const Setup& setup : setups) runners.emplace_back(setup, options);
  size_t next = 0;
  for (bool done = false; !done;) {
    done = true;
    for (Runner& runner : runners) {
      if (runner.Done(budget)) continue;
      runner.Batch(frames, &next, budget);
      done = false;
    }
  }
  std::vector<Measured> measured;
  measured.reserve(runners.size());
  for (const Runner& runner : runners) measured.push_back(runner.Result());
  return measured;
}

}  // namespace topotag::bench
