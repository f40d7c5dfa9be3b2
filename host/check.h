#ifndef TOPOTAG_HOST_CHECK_H_
#define TOPOTAG_HOST_CHECK_H_

#include <string>

namespace topotag {

/// A number of at most so many digits (1 .. 17), with a point whatever the caller's locale is.
std::string NumberText(double value, int digits);
/// The shortest usual form of a number in a message: "0.5", "1e+09".
std::string Text(double value);
/// "640x480".
std::string Text(int width, int height);

/// @throws Error (kInvalidArgument).
[[noreturn]] void FailArgument(const std::string& message);

/// @throws Error (kInvalidArgument) "NAME is null".
void RequireNotNull(const void* pointer, const std::string& name);

/// @throws Error (kInvalidArgument) "NAME VALUE UNIT is not within LOW .. HIGH UNIT", for NaN too.
void RequireRange(const std::string& name, double value, double low, double high,
                  const std::string& unit = "");

/// That a value is one of the enumerators, the first of which is 0: others come from memory that
/// was not set, or from another language.
/// @throws Error (kInvalidArgument) "NAME VALUE is not within 0 .. LAST".
template <typename Enum>
void RequireEnum(const std::string& name, Enum value, Enum last) {
  RequireRange(name, static_cast<int>(value), 0, static_cast<int>(last));
}

}  // namespace topotag

#endif  // TOPOTAG_HOST_CHECK_H_
