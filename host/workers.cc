#include "host/workers.h"

#include <hwy/cache_control.h>

#include <chrono>

namespace topotag {
namespace {

// Longer than the serial parts of a frame, much shorter than the pause between two frames.
constexpr std::chrono::microseconds kSpin{100};
constexpr int kPausesPerLook = 8;

template <typename Condition>
bool SpinUntil(const Condition& condition) {
  const auto end = std::chrono::steady_clock::now() + kSpin;
  do {
    for (int i = 0; i < kPausesPerLook; ++i) {
      if (condition()) return true;
      hwy::Pause();
    }
  } while (std::chrono::steady_clock::now() < end);
  return false;
}

}  // namespace

Workers::Workers(int threads) {
  try {
    for (int i = 1; i < threads; ++i) others_.emplace_back([this] { Serve(); });
  } catch (...) {
    Stop();
    throw;
  }
}

Workers::~Workers() { Stop(); }

void Workers::Stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : others_) thread.join();
}

void Workers::Run(int count, Call call, const void* context) {
  count_ = count;
  call_ = call;
  context_ = context;
  unfinished_.store(count, std::memory_order_relaxed);
  // Sequentially consistent, as the two lines in WaitForTask: either a thread that parks sees the
  // tasks, or it is seen here.
  open_.store(count);
  if (parked_.exchange(false)) {
    { const std::lock_guard<std::mutex> lock(mutex_); }
    wake_.notify_all();
  }
  while (RunOne()) {
  }
  const auto ended = [this] { return unfinished_.load(std::memory_order_acquire) == 0; };
  while (!SpinUntil(ended)) std::this_thread::yield();
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

bool Workers::RunOne() {
  int open = open_.load(std::memory_order_relaxed);
  do {
    if (open == 0) return false;
  } while (!open_.compare_exchange_weak(open, open - 1, std::memory_order_acq_rel,
                                        std::memory_order_relaxed));
  try {
    call_(context_, count_ - open);
  } catch (...) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!error_) error_ = std::current_exception();
  }
  unfinished_.fetch_sub(1, std::memory_order_acq_rel);
  return true;
}

void Workers::Serve() {
  while (WaitForTask()) {
    while (RunOne()) {
    }
  }
}

bool Workers::WaitForTask() {
  const auto ready = [this] { return open_.load() != 0 || stop_.load(); };
  if (!SpinUntil(ready)) {
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
      parked_ = true;
      if (ready()) break;
      wake_.wait(lock);
    }
  }
  return !stop_;
}

}  // namespace topotag
