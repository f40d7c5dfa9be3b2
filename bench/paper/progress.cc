#include "bench/paper/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace topotag::bench::paper {
namespace {

constexpr std::chrono::milliseconds kInterval(200);
constexpr int kBarWidth = 24;

}  // namespace

Progress::Progress(double total_cost)
    : enabled_(isatty(STDERR_FILENO) != 0), total_cost_(total_cost) {}

Progress::~Progress() {
  if (enabled_) std::fputs("\r\033[K", stderr);
}

void Progress::Begin(const std::string& title, double cost) {
  const std::lock_guard<std::mutex> lock(mutex_);
  finished_cost_ += cost_;
  cost_ = cost;
  title_ = title;
  steps_ = done_ = 0;
  Print(true);
}

void Progress::SetSteps(int steps) {
  const std::lock_guard<std::mutex> lock(mutex_);
  steps_ = steps;
}

void Progress::Step() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++done_;
  Print(false);
}

void Progress::Print(bool always) {
  const Clock::time_point now = Clock::now();
  if (!enabled_ || (!always && now - printed_ < kInterval)) return;
  printed_ = now;
  const double part = steps_ > 0 ? std::min(1.0, static_cast<double>(done_) / steps_) : 0;
  const double share = std::min(1.0, (finished_cost_ + part * cost_) / total_cost_);
  const int filled = static_cast<int>(kBarWidth * share);
  std::string left = "?";
  if (share > 0) {
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const long seconds = std::lround(elapsed * (1 - share) / share);
    char text[32];
    std::snprintf(text, sizeof text, "%ld:%02ld", seconds / 60, seconds % 60);
    left = text;
  }
  std::fprintf(stderr, "\r\033[K[%s%s] %3.0f %%  %s left  %s",
               std::string(static_cast<size_t>(filled), '#').c_str(),
               std::string(static_cast<size_t>(kBarWidth - filled), '.').c_str(), 100 * share,
               left.c_str(), title_.c_str());
  std::fflush(stderr);
}

}  // namespace topotag::bench::paper
