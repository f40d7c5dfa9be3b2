// Objects as text: a marker a line.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "host/check.h"
#include "host/file.h"
#include "host/object_name.h"
#include "host/planar_pose.h"
#include "host/rigid_transform.h"
#include "topotag/error.h"
#include "topotag/object.h"

namespace topotag {
namespace {

constexpr size_t kMaxFileSize = size_t{1} << 24;
constexpr size_t kMaxQuoted = 40;
constexpr double kFullTurn = 2 * 3.14159265358979323846;
constexpr std::array<const char*, 9> kFields{"FAMILY", "ID", "SIZE", "TX", "TY",
                                             "TZ",     "RX", "RY",   "RZ"};
constexpr size_t kPoseField = 3;

std::vector<std::string_view> Words(std::string_view line) {
  constexpr const char* kBlank = " \t\r";
  line = line.substr(0, line.find('#'));
  std::vector<std::string_view> words;
  for (;;) {
    const size_t begin = line.find_first_not_of(kBlank);
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    const size_t length = std::min(line.find_first_of(kBlank), line.size());
    words.push_back(line.substr(0, length));
    line.remove_prefix(length);
  }
}

std::string Quoted(std::string_view word) {
  return "'" + std::string(word.substr(0, kMaxQuoted)) + "'";
}

// Reads the lines of one file; where it fails, the message begins with the file and the line.
class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {}

  Object Read() {
    std::string text;
    try {
      text = ReadText(path_, kMaxFileSize);
    } catch (const Error& error) {
      throw Error(error.code(), "cannot read object file '" + path_ + "': " + error.what());
    }
    Object object;
    object.name = std::filesystem::path(path_).stem().string();
    for (size_t begin = 0; begin < text.size();) {
      const size_t end = std::min(text.find('\n', begin), text.size());
      ++line_;
      const std::vector<std::string_view> words =
          Words(std::string_view(text).substr(begin, end - begin));
      begin = end + 1;
      if (!words.empty()) object.markers.push_back(ReadMarker(words));
    }
    if (object.markers.empty()) {
      throw Error(ErrorCode::kParse, path_ + ": the file holds no marker");
    }
    return object;
  }

 private:
  [[noreturn]] void Fail(const std::string& reason) const {
    throw Error(ErrorCode::kParse, path_ + ":" + std::to_string(line_) + ": " + reason);
  }

  double ReadNumber(const std::vector<std::string_view>& words, size_t field) const {
    std::string_view word = words[field];
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    double value = 0;
    const auto parsed = std::from_chars(word.data(), word.data() + word.size(), value);
    if (parsed.ec != std::errc() || parsed.ptr != word.data() + word.size() ||
        !std::isfinite(value)) {
      Fail(std::string(kFields[field]) + " " + Quoted(words[field]) + " is not a finite number");
    }
    return value;
  }

  Family ReadFamily(std::string_view word) const {
    try {
      return Family::Parse(std::string(word.substr(0, kMaxQuoted)));
    } catch (const Error& error) {
      Fail(error.what());
    }
  }

  uint64_t ReadId(std::string_view word) const {
    uint64_t id = 0;
    const auto parsed = std::from_chars(word.data(), word.data() + word.size(), id);
    if (parsed.ec != std::errc() || parsed.ptr != word.data() + word.size()) {
      Fail("ID " + Quoted(word) + " is not a whole number of 0 or more");
    }
    return id;
  }

  void CheckCount(const std::vector<std::string_view>& words) const {
    if (words.size() == kFields.size()) return;
    const bool no_pose = words.size() == kPoseField;
    Fail(std::string(no_pose ? "the pose is missing: " : "") + "expected " +
         std::to_string(kFields.size()) + " values 'FAMILY ID SIZE TX TY TZ RX RY RZ', got " +
         std::to_string(words.size()));
  }

  ObjectMarker ReadMarker(const std::vector<std::string_view>& words) {
    CheckCount(words);
    ObjectMarker marker;
    marker.family = ReadFamily(words[0]);
    marker.id = ReadId(words[1]);
    marker.tag_size = ReadNumber(words, 2);
    for (size_t i = 0; i < 3; ++i) marker.t[i] = ReadNumber(words, kPoseField + i);
    Vector3 rotation;
    for (size_t i = 0; i < 3; ++i) rotation[i] = ReadNumber(words, kPoseField + 3 + i);
    if (!(Dot(rotation, rotation) <= kFullTurn * kFullTurn)) {
      Fail("RX RY RZ is more than a full turn: it is axis times angle in radians");
    }
    marker.R = Exp(rotation);
    const std::string name = MarkerName(marker.family, marker.id);
    const std::string fault = FaultOf(marker);
    if (!fault.empty()) Fail(name + ": " + fault);
    const auto [first, is_new] = lines_.insert({{marker.family.n(), marker.id}, line_});
    if (!is_new) Fail(name + " stands in line " + std::to_string(first->second) + " already");
    return marker;
  }

  const std::string& path_;
  int line_ = 0;
  std::map<std::pair<int, uint64_t>, int> lines_;  ///< of (family n, ID)
};

// What rounding has left of a zero is written as one.
std::string Number(double value) {
  return " " + NumberText(std::abs(value) < 1e-15 ? 0 : value, 13);
}

}  // namespace

Object ReadObject(const std::string& path) { return Reader(path).Read(); }

void WriteObject(const Object& object, const std::string& path) {
  ValidateObject(object);
  std::string text =
      "# family id size tx ty tz rx ry rz\n"
      "# x_object = R x_tag + t; metres, rotation as axis times angle in radians\n";
  for (const ObjectMarker& marker : object.markers) {
    text += marker.family.name() + " " + std::to_string(marker.id) + Number(marker.tag_size);
    for (const double value : marker.t) text += Number(value);
    for (const double value : RotationVector(marker.R)) text += Number(value);
    text += "\n";
  }
  WriteWholeFile(path, text);
}

}  // namespace topotag
