#ifndef TOPOTAG_HOST_ONE_THREAD_H_
#define TOPOTAG_HOST_ONE_THREAD_H_

#include <atomic>

#include "host/check.h"

namespace topotag {

#ifndef NDEBUG

/// Notices where two threads are in the functions of one object at a time. Nothing in builds with
/// NDEBUG.
class OneThread {
 public:
  /// For the time of a call.
  class Use {
   public:
    /// @throws Error (kInvalidArgument) while there is another one
    Use(OneThread* object, const char* what) : object_(object) {
      if (object_->is_used_.exchange(true)) {
        FailArgument(std::string(what) + " is used by two threads at a time");
      }
    }
    ~Use() { object_->is_used_ = false; }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    OneThread* object_;
  };

 private:
  std::atomic<bool> is_used_{false};
};

#else

class OneThread {
 public:
  struct Use {
    Use(OneThread*, const char*) {}
    ~Use() {}  // not trivial: an unused variable of this type is no mistake
  };
};

#endif

}  // namespace topotag

#endif  // TOPOTAG_HOST_ONE_THREAD_H_
