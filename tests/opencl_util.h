#ifndef TOPOTAG_TESTS_OPENCL_UTIL_H_
#define TOPOTAG_TESTS_OPENCL_UTIL_H_

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <optional>
#include <string>

#include "fallback/binarize.h"
#include "fallback/threshold.h"
#include "kernels/binarizer.h"
#include "kernels/device.h"
#include "tests/parity.h"
#include "topotag/error.h"

namespace topotag {

/// An environment variable that is set, or unset, while this exists.
class ScopedVariable {
 public:
  ScopedVariable(const char* name, const std::string& value) : name_(name) {
    if (const char* old = getenv(name)) old_ = old;
    setenv(name, value.c_str(), 1);
  }
  ~ScopedVariable() {
    if (old_) {
      setenv(name_, old_->c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }

 private:
  const char* name_;
  std::optional<std::string> old_;
};

/// What the scalar backend makes of a frame.
struct Reference {
  Reference(const ImageView& image, const ThresholdParams& params) {
    scalar::ThresholdWorkspace workspace;
    scalar::ThresholdMap(image, params, &workspace, &grid);
    scalar::Binarize(image, grid, &bits);
  }
  ThresholdGrid grid;
  BitImage bits;
};

/// The first difference of the frame collected next; empty where there is none.
inline std::string CollectDifference(const Reference& expected, opencl::Binarizer* binarizer) {
  BitImage bits;
  ThresholdGrid grid;
  binarizer->Collect(&bits);
  binarizer->ReadGrid(&grid);
  const std::string difference = Difference(expected.grid, grid);
  return difference.empty() ? Difference(expected.bits, bits) : difference;
}

/// Expects an error of this code whose message has all these parts.
template <typename Call>
void ExpectError(ErrorCode code, std::initializer_list<const char*> parts, Call call) {
  try {
    call();
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    for (const char* part : parts) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
          << part << " is not in: " << error.what();
    }
  }
}

}  // namespace topotag

#endif  // TOPOTAG_TESTS_OPENCL_UTIL_H_
