#ifndef TOPOTAG_HOST_CHECK_H_
#define TOPOTAG_HOST_CHECK_H_

#include <string>

namespace topotag {

/// The shortest usual form of a number in a message: "0.5", "1e+09".
std::string Text(double value);

/// @throws Error (kInvalidArgument).
[[noreturn]] void FailArgument(const std::string& message);

/// @throws Error (kInvalidArgument) "NAME VALUE UNIT is not within LOW .. HIGH UNIT", for NaN too.
void RequireRange(const std::string& name, double value, double low, double high,
                  const std::string& unit = "");

}  // namespace topotag

#endif  // TOPOTAG_HOST_CHECK_H_
