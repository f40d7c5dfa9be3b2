#ifndef TOPOTAG_TOOLS_JSON_NODE_H_
#define TOPOTAG_TOOLS_JSON_NODE_H_

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "topotag/error.h"
#include "topotag/geometry.h"

namespace topotag::tools {

using Json = nlohmann::json;

/// @throws Error (kParse) "WHERE: reason"
[[noreturn]] inline void Fail(const std::string& where, const std::string& reason) {
  throw Error(ErrorCode::kParse, where + ": " + reason);
}

/// An object of a JSON file and how messages name it. Refers to the object.
class JsonNode {
 public:
  JsonNode(const Json& json, std::string where) : json_(json), where_(std::move(where)) {
    if (!json.is_object()) Fail(where_, "is not an object");
  }

  bool Has(const char* key) const { return json_.contains(key); }
  std::string Where(const char* key) const { return where_ + ": " + key; }

  const Json& Get(const char* key) const {
    if (!Has(key)) Fail(where_, std::string("key \"") + key + "\" is missing");
    return json_[key];
  }
  double Number(const char* key) const { return ToNumber(Get(key), Where(key)); }
  double Number(const char* key, double otherwise) const {
    return Has(key) ? Number(key) : otherwise;
  }
  uint64_t Whole(const char* key) const {
    if (!Get(key).is_number_unsigned()) Fail(Where(key), "is not a whole number of 0 or more");
    return Get(key).get<uint64_t>();
  }
  std::string Text(const char* key) const {
    if (!Get(key).is_string()) Fail(Where(key), "is not a string");
    return Get(key).get<std::string>();
  }
  std::string Text(const char* key, const char* otherwise) const {
    return Has(key) ? Text(key) : otherwise;
  }
  bool Flag(const char* key, bool otherwise) const {
    if (!Has(key)) return otherwise;
    if (!Get(key).is_boolean()) Fail(Where(key), "is not true or false");
    return Get(key).get<bool>();
  }
  Vector3 Vector(const char* key) const { return ToVector(Get(key), Where(key)); }
  Point2 Point(const char* key) const { return ToPoint(Get(key), Where(key)); }
  /// A list, or nothing where there is no such key.
  const Json& List(const char* key) const {
    static const Json none = Json::array();
    if (!Has(key)) return none;
    if (!Get(key).is_array()) Fail(Where(key), "is not a list");
    return Get(key);
  }

  void AllowOnly(std::initializer_list<const char*> keys) const {
    for (const auto& item : json_.items()) {
      if (std::find(keys.begin(), keys.end(), item.key()) == keys.end()) {
        Fail(where_, "unknown key \"" + item.key() + "\"");
      }
    }
  }

  static double ToNumber(const Json& json, const std::string& where) {
    if (!json.is_number()) Fail(where, "is not a number");
    return json.get<double>();
  }
  static Vector3 ToVector(const Json& json, const std::string& where) {
    if (!json.is_array() || json.size() != 3) Fail(where, "is not a list of 3 numbers");
    Vector3 vector;
    for (size_t i = 0; i < 3; ++i) vector[i] = ToNumber(json[i], where);
    return vector;
  }
  static Point2 ToPoint(const Json& json, const std::string& where) {
    if (!json.is_array() || json.size() != 2) Fail(where, "is not a list of 2 numbers");
    return {ToNumber(json[0], where), ToNumber(json[1], where)};
  }

 private:
  const Json& json_;
  std::string where_;
};

/// Runs `read` and lets its error name where the value stands.
template <typename Read>
auto At(const std::string& where, Read read) {
  try {
    return read();
  } catch (const Error& error) {
    throw Error(error.code(), where + ": " + error.what());
  }
}

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_JSON_NODE_H_
