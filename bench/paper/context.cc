#include "bench/paper/context.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace topotag::bench::paper {

void ForEachFrame(const Context& context, int count,
                  const std::function<void(int index, int worker)>& work) {
  std::atomic<int> next{0};
  std::mutex mutex;
  std::exception_ptr error;
  const auto run = [&](int worker) {
    try {
      for (int index = next++; index < count; index = next++) {
        work(index, worker);
        context.progress->Step();
      }
    } catch (...) {
      next = count;
      const std::lock_guard<std::mutex> lock(mutex);
      if (!error) error = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  for (int worker = 1; worker < context.threads; ++worker) threads.emplace_back(run, worker);
  run(0);
  for (std::thread& thread : threads) thread.join();
  if (error) std::rethrow_exception(error);
}

}  // namespace topotag::bench::paper
