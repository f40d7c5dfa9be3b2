#ifndef TOPOTAG_HOST_WORKERS_H_
#define TOPOTAG_HOST_WORKERS_H_

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

namespace topotag {

/// The threads that share the work of one frame: the caller and `threads - 1` others.
///
/// Tasks are dealt to the threads in contiguous parts of equal size, so that the stages of a frame
/// find their rows in the same caches; who has ended takes tasks from the end of another's part. So
/// no result may depend on who computes it, and a thread that the system has taken away delays a
/// frame by one task at most. Idle threads spin for a moment, because waking a parked one takes
/// longer than most frames, then park.
/// Thread safety: For is called by one thread at a time. After a fork the child has no other
/// threads: the caller does all of the work, and the destructor waits for nobody.
class Workers {
 public:
  /// @throws Error (kUnavailable) where the system has no more threads
  explicit Workers(int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int threads() const { return static_cast<int>(others_.size()) + 1; }

  /// Calls task(0) .. task(count - 1) and returns when all have ended. The first exception of a
  /// task is thrown here, after the others have ended.
  template <typename Task>
  void For(int count, const Task& task) {
    RunAll(count, task, false);
  }
  /// The same, but every thread begins at the end of its part: after For, what it has seen last is
  /// still in its caches.
  template <typename Task>
  void ForBackward(int count, const Task& task) {
    RunAll(count, task, true);
  }

 private:
  using Call = void (*)(const void* context, int index);

  /// Tasks of one thread that nobody has taken: first in the upper half, end in the lower.
  struct alignas(64) Part {
    std::atomic<uint64_t> open{0};
  };

  template <typename Task>
  void RunAll(int count, const Task& task, bool backward) {
    static_assert(std::is_invocable_v<const Task&, int>);
    if (count <= 1 || others_.empty()) {
      for (int i = 0; i < count; ++i) task(backward ? count - 1 - i : i);
      return;
    }
    backward_.store(backward, std::memory_order_relaxed);
    Run(
        count, [](const void* context, int i) { (*static_cast<const Task*>(context))(i); }, &task);
  }

  void Run(int count, Call call, const void* context);
  void RunOpen(size_t thread);
  void RunOne(int index);
  void Serve(size_t thread);
  bool WaitForJob(uint32_t* seen);
  void Stop();

  // Also read by who then finds that the job has ended: every value gives a task once.
  std::atomic<bool> backward_{false};
  // The job under way, written before its parts are opened and read by who has taken a task of it.
  Call call_ = nullptr;
  const void* context_ = nullptr;
  std::exception_ptr error_;
  std::vector<Part> parts_;
  alignas(64) std::atomic<int> unfinished_{0};  ///< tasks that have not ended
  alignas(64) std::atomic<uint32_t> job_{0};    ///< counts the jobs
  std::atomic<bool> parked_{false};
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::unique_ptr<std::condition_variable> wake_ = std::make_unique<std::condition_variable>();
  const int process_;  ///< that the threads are of
  std::vector<std::thread> others_;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_WORKERS_H_
