#ifndef TOPOTAG_TESTS_FAILING_ALLOCATIONS_H_
#define TOPOTAG_TESTS_FAILING_ALLOCATIONS_H_

// Allocations that fail, one after the other. In one source file of a test.

#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <string>

#include "tests/allocation_hooks.h"
#include "topotag/error.h"

namespace topotag::test {

inline std::atomic<bool> is_armed{false};
inline std::atomic<int> before_failure{0};
inline std::atomic<int> failures{0};
inline std::atomic<bool> fails_for_good{false};

/// While this exists, allocation `index` fails, and if `for_good`, all that come after it.
class FailingAllocation {
 public:
  FailingAllocation(int index, bool for_good) {
    before_failure = index;
    failures = 0;
    fails_for_good = for_good;
    is_armed = true;
  }
  ~FailingAllocation() { is_armed = false; }
};

/// Calls work(), with something made by make(), again and again, each time with another of its
/// allocations failing, until it needs no more; check() follows with what was made, where make()
/// was left alone. Then the same with no memory at all from there on. Of many allocations, only
/// every so many fail.
template <typename Make, typename Work, typename Check>
void FailEachAllocation(const Make& make, const Work& work, const Check& check) {
  for (const bool for_good : {false, true}) {
    int index = 0;
    for (bool failed = true; failed; index += 1 + index / 24) {
      auto made = make();
      try {
        const FailingAllocation failing(index, for_good);
        work(&made);
      } catch (const std::bad_alloc&) {
      } catch (const Error&) {
        // As good: there are files that cannot be read for lack of memory.
      } catch (const std::exception& error) {
        ADD_FAILURE() << "allocation " << index << ": " << error.what();
      }
      failed = failures > 0;
      check(&made);
      if (testing::Test::HasFailure()) {
        ADD_FAILURE() << "after a failure of allocation " << index << (for_good ? " and on" : "");
        return;
      }
    }
    EXPECT_GT(index, 1) << "nothing was allocated";
  }
}

struct Nothing {};

/// The same where there is nothing to make and to check.
template <typename Work>
void FailEachAllocation(const Work& work) {
  FailEachAllocation([] { return Nothing(); }, [&](Nothing*) { work(); }, [](Nothing*) {});
}

}  // namespace topotag::test

void OnAllocate(void*) {
  using namespace topotag::test;
  if (!is_armed) return;
  const int left = before_failure--;
  if (left > 0 || (left < 0 && !fails_for_good)) return;
  ++failures;
  throw std::bad_alloc();
}
void OnFree(void*) {}

#endif  // TOPOTAG_TESTS_FAILING_ALLOCATIONS_H_
