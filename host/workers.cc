#include "host/workers.h"

#include <hwy/cache_control.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <system_error>

#include "topotag/error.h"

namespace topotag {
namespace {

// Longer than the serial parts of a frame, much shorter than the pause between two frames.
constexpr std::chrono::microseconds kSpin{100};
constexpr int kPausesPerLook = 8;

constexpr uint64_t Pack(uint64_t first, uint64_t end) { return first << 32 | end; }
constexpr uint64_t First(uint64_t part) { return part >> 32; }
constexpr uint64_t End(uint64_t part) { return part & 0xffffffff; }

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

Workers::Workers(int threads) : parts_(static_cast<size_t>(threads)), process_(getpid()) {
  try {
    for (size_t i = 1; i < parts_.size(); ++i) others_.emplace_back([this, i] { Serve(i); });
  } catch (const std::system_error& error) {
    Stop();
    throw Error(ErrorCode::kUnavailable, "the system has no " + std::to_string(threads) +
                                             " threads: " + error.code().message());
  } catch (...) {
    Stop();
    throw;
  }
}

Workers::~Workers() {
  if (getpid() == process_) {
    Stop();
    return;
  }
  // Threads that only the parent has would be waited for without end: so does a condition that some
  // of them wait for.
  for (std::thread& thread : others_) thread.detach();
  static_cast<void>(wake_.release());
}

void Workers::Stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  wake_->notify_all();
  for (std::thread& thread : others_) thread.join();
}

void Workers::Run(int count, Call call, const void* context) {
  call_ = call;
  context_ = context;
  unfinished_.store(count, std::memory_order_relaxed);
  const uint64_t threads = parts_.size();
  const auto tasks = static_cast<uint64_t>(count);
  for (uint64_t i = 0; i < threads; ++i) {
    parts_[i].open.store(Pack(tasks * i / threads, tasks * (i + 1) / threads),
                         std::memory_order_release);
  }
  // Sequentially consistent, as the two lines in WaitForJob: either a thread that parks sees the
  // job, or it is seen here.
  job_.fetch_add(1);
  if (parked_.exchange(false)) {
    { const std::lock_guard<std::mutex> lock(mutex_); }
    wake_->notify_all();
  }
  RunOpen(0);
  const auto ended = [this] { return unfinished_.load(std::memory_order_acquire) == 0; };
  while (!SpinUntil(ended)) std::this_thread::yield();
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void Workers::RunOpen(size_t thread) {
  for (size_t i = 0; i < parts_.size(); ++i) {
    std::atomic<uint64_t>& part = parts_[(thread + i) % parts_.size()].open;
    uint64_t open = part.load(std::memory_order_acquire);
    while (First(open) != End(open)) {
      // From the other end of somebody else's part.
      const bool from_front = (i == 0) != backward_.load(std::memory_order_relaxed);
      const uint64_t left =
          from_front ? Pack(First(open) + 1, End(open)) : Pack(First(open), End(open) - 1);
      if (!part.compare_exchange_weak(open, left, std::memory_order_acq_rel,
                                      std::memory_order_acquire)) {
        continue;
      }
      RunOne(static_cast<int>(from_front ? First(open) : End(left)));
      open = part.load(std::memory_order_acquire);
    }
  }
}

void Workers::RunOne(int index) {
  try {
    call_(context_, index);
  } catch (...) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!error_) error_ = std::current_exception();
  }
  unfinished_.fetch_sub(1, std::memory_order_acq_rel);
}

void Workers::Serve(size_t thread) {
  uint32_t seen = 0;
  while (WaitForJob(&seen)) RunOpen(thread);
}

bool Workers::WaitForJob(uint32_t* seen) {
  const auto ready = [&] { return job_.load() != *seen || stop_.load(); };
  if (!SpinUntil(ready)) {
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
      parked_ = true;
      if (ready()) break;
      wake_->wait(lock);
    }
  }
  *seen = job_.load();
  return !stop_;
}

}  // namespace topotag
