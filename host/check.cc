#include "host/check.h"

#include <array>
#include <charconv>

#include "topotag/error.h"

namespace topotag {

std::string NumberText(double value, int digits) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, digits);
  return std::string(text.data(), end.ptr);
}

std::string Text(double value) { return NumberText(value, 6); }

std::string Text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

void FailArgument(const std::string& message) { throw Error(ErrorCode::kInvalidArgument, message); }

void RequireNotNull(const void* pointer, const std::string& name) {
  if (pointer == nullptr) FailArgument(name + " is null");
}

void RequireRange(const std::string& name, double value, double low, double high,
                  const std::string& unit) {
  // Written so that NaN fails too.
  if (value >= low && value <= high) return;
  const std::string with_unit = unit.empty() ? "" : " " + unit;
  FailArgument(name + " " + Text(value) + with_unit + " is not within " + Text(low) + " .. " +
               Text(high) + with_unit);
}

}  // namespace topotag
