// The user's outer shape: one "x y" pair in units a line.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <system_error>

#include "host/file.h"
#include "topotag/error.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

constexpr size_t kMaxFileSize = size_t{1} << 20;
constexpr size_t kMaxQuoted = 40;

// Parses one "x y" line; false where it is neither that nor blank. `found` tells the two apart.
bool ParsePoint(std::string_view line, Point2* point, bool* found) {
  constexpr const char* kBlank = " \t\r";
  double values[2];
  int count = 0;
  line = line.substr(0, line.find('#'));
  for (;;) {
    const size_t begin = line.find_first_not_of(kBlank);
    if (begin == std::string_view::npos) break;
    line.remove_prefix(begin);
    const size_t length = std::min(line.find_first_of(kBlank), line.size());
    if (count == 2) return false;
    const auto parsed = std::from_chars(line.data(), line.data() + length, values[count]);
    if (parsed.ec != std::errc() || parsed.ptr != line.data() + length) return false;
    if (!std::isfinite(values[count++])) return false;
    line.remove_prefix(length);
  }
  *found = count == 2;
  if (*found) *point = {values[0], values[1]};
  return count != 1;
}

}  // namespace

std::vector<Point2> ReadPolygon(const std::string& path) {
  std::string text;
  try {
    text = ReadText(path, kMaxFileSize);
  } catch (const Error& error) {
    throw Error(error.code(), "cannot read polygon file '" + path + "': " + error.what());
  }
  std::vector<Point2> polygon;
  int number = 1;
  for (size_t begin = 0; begin < text.size(); ++number) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    Point2 point;
    bool found = false;
    if (!ParsePoint(line, &point, &found)) {
      throw Error(ErrorCode::kParse, path + ":" + std::to_string(number) +
                                         ": expected two numbers 'x y', got '" +
                                         std::string(line.substr(0, kMaxQuoted)) + "'");
    }
    if (found) polygon.push_back(point);
  }
  if (polygon.empty()) throw Error(ErrorCode::kParse, path + ": the file holds no point");
  return polygon;
}

}  // namespace topotag
