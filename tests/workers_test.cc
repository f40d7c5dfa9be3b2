#include "host/workers.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/random_image.h"

namespace topotag {
namespace {

// Each of `count` tasks runs once, whoever runs it.
void ExpectEachOnce(Workers* workers, int count, bool backward = false) {
  std::vector<std::atomic<int>> calls(static_cast<size_t>(count));
  std::atomic<int> others{0};
  const auto task = [&](int i) {
    if (i < 0 || i >= count) {
      ++others;
    } else {
      calls[static_cast<size_t>(i)].fetch_add(1, std::memory_order_relaxed);
    }
  };
  if (backward) {
    workers->ForBackward(count, task);
  } else {
    workers->For(count, task);
  }
  ASSERT_EQ(others, 0);
  for (const std::atomic<int>& c : calls) ASSERT_EQ(c, 1) << "of " << count << " tasks";
}

class WorkersTest : public ::testing::TestWithParam<int> {
 protected:
  Workers workers_{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Threads, WorkersTest, ::testing::Range(1, 9));

TEST_P(WorkersTest, AsManyThreadsAsAskedFor) { EXPECT_EQ(workers_.threads(), GetParam()); }

TEST_P(WorkersTest, EveryIndexOnce) {
  for (const int count : {0, 1, 2, 3, 7, 8, 9, 16, 100, 1000, 10000}) {
    ExpectEachOnce(&workers_, count);
  }
}

TEST_P(WorkersTest, EveryTaskOnceInEitherDirection) {
  Random random(2);
  for (int job = 0; job < 20000; ++job) {
    const bool is_backward = random.Chance(50);
    ExpectEachOnce(&workers_, random.Below(12), is_backward);
    if (HasFatalFailure()) return;
  }
}

// Ten tasks for each thread: the caller runs its own in order while the others are held up in
// theirs.
TEST_P(WorkersTest, TheCallersPartInOrder) {
  const std::thread::id caller = std::this_thread::get_id();
  for (const bool backward : {false, true}) {
    std::atomic<bool> caller_has_ended{false};
    std::vector<int> order;
    const auto task = [&](int i) {
      if (std::this_thread::get_id() == caller) {
        order.push_back(i);
        if (order.size() == 10) caller_has_ended = true;
      } else {
        while (!caller_has_ended) std::this_thread::yield();
      }
    };
    if (backward) {
      workers_.ForBackward(10 * GetParam(), task);
    } else {
      workers_.For(10 * GetParam(), task);
    }
    ASSERT_GE(order.size(), 10u);
    for (int i = 0; i < 10; ++i) {
      EXPECT_EQ(order[static_cast<size_t>(i)], backward ? 9 - i : i);
    }
  }
}

// A thread that is held up in one task delays no other one.
TEST_P(WorkersTest, OthersTakeTheTasksOfAThreadThatIsBusy) {
  const std::thread::id caller = std::this_thread::get_id();
  const int count = 10 * GetParam();
  for (const bool backward : {false, true}) {
    std::atomic<int> ended{0};
    bool first_of_caller = GetParam() > 1;
    const auto task = [&](int) {
      if (std::this_thread::get_id() == caller && first_of_caller) {
        first_of_caller = false;
        const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (ended < count - 1 && std::chrono::steady_clock::now() < limit) {
          std::this_thread::yield();
        }
        EXPECT_EQ(ended, count - 1);
      }
      ++ended;
    };
    if (backward) {
      workers_.ForBackward(count, task);
    } else {
      workers_.For(count, task);
    }
    EXPECT_EQ(ended, count);
  }
}

TEST_P(WorkersTest, NoTaskRunsForACountBelowOne) {
  bool ran = false;
  workers_.For(0, [&](int) { ran = true; });
  workers_.For(-3, [&](int) { ran = true; });
  EXPECT_FALSE(ran);
}

// For returns after the last task: what tasks wrote is seen, and the next job sees it too.
TEST_P(WorkersTest, JobsInARow) {
  std::vector<int> numbers(5);
  for (int job = 0; job < 20000; ++job) {
    const int count = 1 + job % 5;
    workers_.For(count, [&](int i) { numbers[static_cast<size_t>(i)] += 1; });
    // A task of the job before runs no more: it would add to the next job's numbers.
    const int at_first = numbers[0];
    ASSERT_EQ(at_first, job + 1);
  }
  EXPECT_EQ(numbers, (std::vector<int>{20000, 16000, 12000, 8000, 4000}));
}

// Jobs of different types right after each other, of a frame's kind: many, few, one.
TEST_P(WorkersTest, FramesInARow) {
  std::vector<int> first(40), second(3);
  for (int frame = 0; frame < 3000; ++frame) {
    workers_.For(40, [&](int i) { first[static_cast<size_t>(i)] = frame + i; });
    workers_.For(3, [&](int i) {
      second[static_cast<size_t>(i)] =
          std::accumulate(first.begin() + 13 * i, first.begin() + 13 * (i + 1), 0);
    });
    int sum = 0;
    workers_.For(1, [&](int) { sum = second[0] + second[1] + second[2]; });
    ASSERT_EQ(sum, 39 * frame + 38 * 39 / 2);
  }
}

TEST_P(WorkersTest, TheCallersThreadTakesPart) {
  const std::thread::id caller = std::this_thread::get_id();
  bool took_part = false;
  for (int job = 0; job < 1000 && !took_part; ++job) {
    workers_.For(64, [&](int) {
      if (std::this_thread::get_id() == caller) took_part = true;
    });
  }
  EXPECT_TRUE(took_part);
}

// Two tasks that wait for each other end only where two threads run them.
TEST_P(WorkersTest, TasksRunAtTheSameTime) {
  const int threads = GetParam();
  for (int job = 0; job < 20; ++job) {
    std::atomic<int> arrived{0};
    workers_.For(threads, [&](int) {
      arrived.fetch_add(1);
      while (arrived.load() < threads) std::this_thread::yield();
    });
    ASSERT_EQ(arrived, threads);
  }
}

// After longer than the threads spin, they are parked: that they wake up is seen where every one
// of them must take a task.
TEST_P(WorkersTest, ParkedThreadsWakeUp) {
  const int threads = GetParam();
  for (int job = 0; job < 60; ++job) {
    // Around the time at which they park, and long after.
    std::this_thread::sleep_for(std::chrono::microseconds(job % 3 == 2 ? 3000 : 60 + 3 * job));
    std::atomic<int> arrived{0};
    workers_.For(threads, [&](int) {
      arrived.fetch_add(1);
      while (arrived.load() < threads) std::this_thread::yield();
    });
    ASSERT_EQ(arrived, threads);
    ExpectEachOnce(&workers_, 5);
  }
}

TEST_P(WorkersTest, AnExceptionIsThrownToTheCaller) {
  for (int job = 0; job < 300; ++job) {
    const int count = 1 + job % 17, thrower = job % count;
    std::vector<std::atomic<int>> ended(static_cast<size_t>(count));
    try {
      workers_.For(count, [&](int i) {
        if (i == thrower) throw std::runtime_error("task " + std::to_string(i));
        ended[static_cast<size_t>(i)] = 1;
      });
      FAIL() << "no exception";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), "task " + std::to_string(thrower));
    }
    // With one thread the rest of the job is not run; with more, all other tasks have ended.
    if (GetParam() > 1 && count > 1) {
      for (int i = 0; i < count; ++i) {
        ASSERT_EQ(ended[static_cast<size_t>(i)], i == thrower ? 0 : 1);
      }
    }
    ExpectEachOnce(&workers_, count);
  }
}

TEST_P(WorkersTest, TheFirstExceptionIsThrown) {
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<int> ended{0};
  try {
    workers_.For(10 * GetParam(), [&](int i) {
      if (std::this_thread::get_id() == caller) {
        if (++ended <= 10) throw i;
      } else {
        while (ended < 10) std::this_thread::yield();
      }
    });
    FAIL() << "no exception";
  } catch (int i) {
    EXPECT_EQ(i, 0);
  }
}

TEST_P(WorkersTest, OneOfManyExceptions) {
  for (int job = 0; job < 300; ++job) {
    try {
      workers_.For(20, [](int i) { throw i; });
      FAIL() << "no exception";
    } catch (int i) {
      EXPECT_GE(i, 0);
      EXPECT_LT(i, 20);
    }
    ExpectEachOnce(&workers_, 20);  // nothing is left of them
  }
}

TEST_P(WorkersTest, MadeAndDestroyedAThousandTimes) {
  for (int i = 0; i < 1000; ++i) {
    Workers workers(GetParam());
    if (i % 3 == 0) continue;  // without a job
    ExpectEachOnce(&workers, i % 3 == 1 ? 1 : 9);
    if (i % 50 == 1) std::this_thread::sleep_for(std::chrono::microseconds(200));  // parked
  }
}

// A Workers for each of several threads: nothing is shared.
TEST(WorkersTest, SeveralAtOnce) {
  std::vector<std::thread> threads;
  std::atomic<int> failures{0};
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      Workers workers(3);
      for (int job = 0; job < 500; ++job) {
        std::atomic<int> sum{0};
        workers.For(10, [&](int i) { sum += i; });
        if (sum != 45) ++failures;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(failures, 0);
}

// A daemon makes itself from a process that has a detector; the child has no other threads.
TEST(WorkersForkTest, AChildCanWorkAndEnd) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the thread sanitizer does not follow a fork";
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
  GTEST_SKIP() << "the thread sanitizer does not follow a fork";
#endif
#endif
  auto workers = std::make_unique<Workers>(4);
  ExpectEachOnce(workers.get(), 100);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // the others have parked
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    alarm(20);
    ExpectEachOnce(workers.get(), 100);
    workers.reset();
    _exit(HasFailure() ? 1 : 0);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  ExpectEachOnce(workers.get(), 100);
}

}  // namespace
}  // namespace topotag
