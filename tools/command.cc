#include "tools/command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <new>
#include <opencv2/core.hpp>

#include "host/one_line.h"
#include "topotag/error.h"

namespace topotag::tools {

namespace {

auto RefuseEmpty(const char* what) {
  return [what](const std::string& text) {
    return text.empty() ? std::string("the ") + what + " is empty" : std::string();
  };
}

}  // namespace

CLI::Option* AddInputs(CLI::App* command, const char* name, std::vector<std::string>* inputs,
                       const char* help) {
  CLI::Option* const option = command->add_option(name, *inputs, help);
  return option->required()->type_name("")->check(RefuseEmpty("name"));
}

CLI::Option* AddText(CLI::App* command, const char* group, const char* name, std::string* value,
                     const char* type, const char* help) {
  CLI::Option* const option = command->add_option(name, *value, help);
  return option->type_name(type)->group(group)->check(RefuseEmpty("value"));
}

double ParseNumber(const std::string& option, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool whole = !text.empty() && !std::isspace(static_cast<unsigned char>(text[0])) &&
                     end == text.c_str() + text.size();
  if (!whole || !std::isfinite(value)) {
    throw UsageError(option + ": '" + text + "' is not a finite number");
  }
  return value;
}

double ParsePositive(const std::string& option, const std::string& text) {
  const double value = ParseNumber(option, text);
  if (!(value > 0)) throw UsageError(option + ": " + text + " is not greater than 0");
  return value;
}

double ParseNotNegative(const std::string& option, const std::string& text) {
  const double value = ParseNumber(option, text);
  if (!(value >= 0)) throw UsageError(option + ": " + text + " is less than 0");
  return value;
}

uint64_t ParseUnsigned(const std::string& option, const std::string& text) {
  const auto fail = [&]() {
    throw UsageError(option + ": '" + text + "' is not a whole number of 0 or more");
  };
  uint64_t value = 0;
  if (text.empty()) fail();
  for (const char c : text) {
    if (c < '0' || c > '9') fail();
    const uint64_t digit = static_cast<uint64_t>(c - '0');
    if (value > (std::numeric_limits<uint64_t>::max() - digit) / 10) {
      throw UsageError(option + ": " + text + " is too large");
    }
    value = value * 10 + digit;
  }
  return value;
}

std::vector<double> ParseNumbers(const std::string& option, const std::string& text, size_t count) {
  std::vector<double> values;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    values.push_back(ParseNumber(option, text.substr(begin, end - begin)));
    begin = end + 1;
  }
  if (values.size() != count) {
    throw UsageError(option + ": '" + text + "' has " + std::to_string(values.size()) +
                     " numbers instead of " + std::to_string(count));
  }
  return values;
}

uint64_t ParseId(const std::string& option, const std::string& text, Family family) {
  const uint64_t id = ParseUnsigned(option, text);
  ForOption(option, [&] {
    CheckId(family, id);
    return 0;
  });
  return id;
}

std::vector<uint64_t> ParseIds(const std::string& option, const std::string& text, Family family) {
  // More markers than this in one call are a slip of the keyboard.
  constexpr uint64_t kMaxMarkers = 1000000;
  std::vector<uint64_t> ids;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const size_t dash = part.find('-');
    if (part.empty() || dash == 0 || dash == part.size() - 1) {
      throw UsageError(option + ": '" + part + "' is not an ID or a range of IDs");
    }
    const uint64_t first = ParseId(option, part.substr(0, dash), family);
    const uint64_t last =
        dash == std::string::npos ? first : ParseId(option, part.substr(dash + 1), family);
    if (last < first) throw UsageError(option + ": the range " + part + " is empty");
    if (last - first >= kMaxMarkers - ids.size()) {
      throw UsageError(option + ": " + text + " are more than " + std::to_string(kMaxMarkers) +
                       " markers");
    }
    for (uint64_t id = first; id <= last; ++id) ids.push_back(id);
    begin = end + 1;
  }
  return ids;
}

void CheckChoice(const std::string& option, const std::string& value,
                 std::initializer_list<const char*> choices) {
  std::string names;
  for (const char* choice : choices) {
    if (value == choice) return;
    if (!names.empty()) names += ", ";
    names += choice;
  }
  throw UsageError(option + ": '" + value + "' is not one of " + names);
}

bool SetNamedOuterShape(const std::string& name, MarkerDesign* design) {
  for (const OuterShape shape :
       {OuterShape::kSquare, OuterShape::kCircle, OuterShape::kButterfly}) {
    if (name != Name(shape)) continue;
    design->outer = shape;
    return true;
  }
  return false;
}

void SetOuterShape(const std::string& name_or_file, MarkerDesign* design) {
  if (SetNamedOuterShape(name_or_file, design)) return;
  std::error_code ignored;
  if (!std::filesystem::exists(name_or_file, ignored)) {
    throw Error(ErrorCode::kInvalidArgument,
                "'" + name_or_file + "' is not one of square, circle, butterfly, and no file");
  }
  design->polygon = ReadPolygon(name_or_file);
  design->outer = OuterShape::kPolygon;
}

void CheckId(Family family, uint64_t id) {
  if (id >= family.size()) {
    throw Error(ErrorCode::kInvalidArgument,
                "ID " + std::to_string(id) + " is outside the range 0 .. " +
                    std::to_string(family.size() - 1) + " of " + family.name());
  }
}

std::string Describe(const std::exception& error) {
  const auto* of_opencv = dynamic_cast<const cv::Exception*>(&error);
  const bool is_memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
                         (of_opencv != nullptr && of_opencv->code == cv::Error::StsNoMem);
  return is_memory ? "not enough memory" : error.what();
}

void Complain(const std::string& message) {
  std::fprintf(stderr, "topotag: %s\n", OneLine(message).c_str());
}

std::string Named(const std::string& name, const std::string& message) {
  const std::string subject = OneLine(name);  // as errors quote it
  if (message.compare(0, subject.size() + 2, subject + ": ") == 0) return message;
  // "cannot read 'a.png': reason" becomes "a.png: cannot read: reason".
  const std::string quoted = " '" + subject + "'";
  const size_t at = message.find(quoted);
  if (at == std::string::npos) return subject + ": " + message;
  return subject + ": " + message.substr(0, at) + message.substr(at + quoted.size());
}

}  // namespace topotag::tools
