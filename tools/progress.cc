#include "tools/progress.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <string>

namespace topotag::tools {
namespace {

constexpr std::chrono::milliseconds kInterval(100);
constexpr int kBarWidth = 24;

}  // namespace

Progress::Progress(bool enabled, int64_t total) : enabled_(enabled && total != 1), total_(total) {}

Progress::~Progress() { Clear(); }

void Progress::Step() {
  ++done_;
  const Clock::time_point now = Clock::now();
  if (!enabled_ || now - last_ < kInterval) return;
  last_ = now;
  Print(std::chrono::duration<double>(now - start_).count());
  shown_ = true;
}

void Progress::Clear() {
  if (!shown_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  shown_ = false;
  last_ = {};
}

void Progress::Print(double seconds) const {
  const double rate = seconds > 0 ? static_cast<double>(done_) / seconds : 0;
  if (total_ == 0) {
    std::fprintf(stderr, "\r\033[K%" PRId64 " frames  %.1f frames/s", done_, rate);
  } else {
    // The length of a video is its header's claim: more frames than that may come.
    const int64_t total = std::max(total_, done_);
    const int filled = static_cast<int>(kBarWidth * done_ / total);
    const int64_t left = rate > 0 ? std::llround((total - done_) / rate) : 0;
    std::fprintf(stderr,
                 "\r\033[K[%s%s] %" PRId64 "/%" PRId64 "  %.1f frames/s  %" PRId64 ":%02d left",
                 std::string(filled, '#').c_str(), std::string(kBarWidth - filled, '.').c_str(),
                 done_, total, rate, left / 60, static_cast<int>(left % 60));
  }
  std::fflush(stderr);
}

}  // namespace topotag::tools
