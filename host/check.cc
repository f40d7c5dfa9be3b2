#include "host/check.h"

#include <cstdio>

#include "topotag/error.h"

namespace topotag {

std::string Text(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", value);
  return text;
}

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
