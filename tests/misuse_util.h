#ifndef TOPOTAG_TESTS_MISUSE_UTIL_H_
#define TOPOTAG_TESTS_MISUSE_UTIL_H_

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "topotag/error.h"

namespace topotag {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// The values that no length, count or scale may have.
constexpr double kNotPositive[] = {0, -1, kNan, kInf, -kInf};
constexpr double kNotFinite[] = {kNan, kInf, -kInf};

/// Expects an Error of this code, in one line that holds `part`.
template <typename Call>
void ExpectRefused(ErrorCode code, const std::string& part, const Call& call) {
  try {
    call();
    ADD_FAILURE() << "no error; expected one about " << part;
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.code(), code) << message;
    EXPECT_NE(message.find(part), std::string::npos) << part << " is not in: " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

template <typename Call>
void ExpectRefused(const std::string& part, const Call& call) {
  ExpectRefused(ErrorCode::kInvalidArgument, part, call);
}

/// Calls what may be refused, but not with anything else than an Error: that it is undefined
/// behaviour, the sanitizers see.
template <typename Call>
void ExpectDefined(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument) << error.what();
  }
}

}  // namespace topotag

#endif  // TOPOTAG_TESTS_MISUSE_UTIL_H_
