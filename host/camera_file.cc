// Calibration files: OpenCV YAML and JSON, ROS camera_info, the TopoTag authors' keys.
#include "topotag/camera_file.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <vector>

#include "host/check.h"
#include "host/file.h"
#include "topotag/error.h"

namespace topotag {
namespace {

constexpr size_t kMaxFileSize = size_t{1} << 20;
// More than any key holds: a longer list is wrong, whatever follows.
constexpr size_t kMaxNumbers = 64;
constexpr int kMaxNesting = 2;
constexpr size_t kMaxQuoted = 40;
// Of the focal length: a thousandth of a pixel at 45 degrees.
constexpr double kSkewTolerance = 1e-6;
constexpr double kZeroTolerance = 1e-9;

[[noreturn]] void Fail(ErrorCode code, const std::string& path, const std::string& reason) {
  throw Error(code, "camera file '" + path + "': " + reason);
}

std::string Quoted(const std::string& text) {
  return "'" + (text.size() <= kMaxQuoted ? text : text.substr(0, kMaxQuoted) + "...") + "'";
}

std::string ToText(double value) { return NumberText(value, 17); }

std::string ReadYaml(const std::string& path) {
  std::string text;
  try {
    text = ReadText(path, kMaxFileSize);
  } catch (const Error& error) {
    Fail(error.code(), path, std::string("cannot be read: ") + error.what());
  }
  if (text.empty()) Fail(ErrorCode::kParse, path, "is empty");
  if (text.find('\0') != std::string::npos) Fail(ErrorCode::kParse, path, "is not a text file");
  return text;
}

// Makes YAML 1.2 of OpenCV's dialect: its first line, "%YAML:1.0", is no valid directive. JSON is
// YAML but for tabs as white space.
std::string Normalize(std::string text) {
  static constexpr char kByteOrderMark[] = "\xEF\xBB\xBF";
  if (text.compare(0, 3, kByteOrderMark) == 0) text.erase(0, 3);
  if (text.compare(0, 5, "%YAML") == 0) text[0] = '#';
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '{') {
    std::replace(text.begin(), text.end(), '\t', ' ');
  }
  return text;
}

class CameraReader {
 public:
  explicit CameraReader(const std::string& path)
      : path_(path), root_(YAML::Load(Normalize(ReadYaml(path)))) {
    if (!root_.IsMap()) Fail("is neither a YAML nor a JSON map of keys");
  }

  Camera Read() const {
    Camera camera;
    camera.width = ReadInteger("image_width");
    camera.height = ReadInteger("image_height");
    if (Has("image_width") != Has("image_height")) {
      Fail(Has("image_width") ? "image_width without image_height"
                              : "image_height without image_width");
    }
    ReadCameraMatrix(&camera);
    ReadDistortion(&camera);
    try {
      ValidateCamera(camera);
    } catch (const Error& error) {
      Fail(error.what());
    }
    return camera;
  }

 private:
  [[noreturn]] void Fail(const std::string& reason) const {
    topotag::Fail(ErrorCode::kParse, path_, reason);
  }

  bool Has(const char* key) const { return static_cast<bool>(root_[key]); }

  // The key of the two that the file uses.
  const char* FindKey(const char* key, const char* authors_key) const {
    if (Has(key)) return key;
    if (Has(authors_key)) return authors_key;
    Fail(std::string("no key ") + key + " (or " + authors_key + ")");
  }

  template <typename T>
  static bool ParseNumber(const YAML::Node& node, T* value) {
    if (!node.IsScalar()) return false;
    const std::string& text = node.Scalar();
    // A leading plus sign is YAML, but not from_chars.
    const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
    const char* begin = text.data() + (plus ? 1 : 0);
    const char* end = text.data() + text.size();
    const auto result = std::from_chars(begin, end, *value);
    return result.ec == std::errc() && result.ptr == end;
  }

  // 0 where the key is absent.
  int ReadInteger(const char* key) const {
    const YAML::Node node = root_[key];
    int value = 0;
    if (node && !ParseNumber(node, &value)) {
      Fail(std::string(key) + " " + (node.IsScalar() ? Quoted(node.Scalar()) + " " : "") +
           "is not an integer");
    }
    return value;
  }

  void Flatten(const char* key, const YAML::Node& node, int nesting,
               std::vector<double>* numbers) const {
    if (node.IsSequence() && nesting < kMaxNesting) {
      for (const YAML::Node& child : node) Flatten(key, child, nesting + 1, numbers);
      return;
    }
    const std::string element = std::string(key) + " element " + std::to_string(numbers->size());
    if (numbers->size() == kMaxNumbers) Fail(std::string(key) + " has too many elements");
    if (!node.IsScalar()) Fail(element + " is not a number");
    double value = 0;
    if (!ParseNumber(node, &value))
      Fail(element + " " + Quoted(node.Scalar()) + " is not a number");
    if (!std::isfinite(value)) Fail(element + " " + Quoted(node.Scalar()) + " is not finite");
    numbers->push_back(value);
  }

  // A nested or flat list, or a map of rows, cols and data. `rows`, `cols`: the required shape, or
  // 0 for any.
  std::vector<double> ReadMatrix(const char* key, int rows, int cols) const {
    const std::string name = key;
    const YAML::Node node = root_[key];
    std::vector<double> numbers;
    if (node.IsSequence()) {
      const bool nested = node.size() > 0 && node[0].IsSequence();
      if (nested && rows > 0) {
        for (const YAML::Node& row : node) {
          if (!row.IsSequence() || row.size() != static_cast<size_t>(cols)) {
            Fail(name + " has a row that is not a list of " + std::to_string(cols) + " numbers");
          }
        }
      }
      Flatten(key, node, 0, &numbers);
      return numbers;
    }
    if (!node.IsMap()) Fail(name + " is neither a list nor a map of rows, cols and data");
    int stated_rows = 0, stated_cols = 0;
    const YAML::Node data = node["data"];
    if (!node["rows"] || !ParseNumber(node["rows"], &stated_rows) || stated_rows < 0) {
      Fail(name + ": rows is missing or no number of rows");
    }
    if (!node["cols"] || !ParseNumber(node["cols"], &stated_cols) || stated_cols < 0) {
      Fail(name + ": cols is missing or no number of columns");
    }
    if (!data || !data.IsSequence()) Fail(name + ": data is missing or not a list");
    const std::string shape = std::to_string(stated_rows) + "x" + std::to_string(stated_cols);
    if (rows > 0 && (stated_rows != rows || stated_cols != cols)) {
      Fail(name + " is " + shape + ", expected " + std::to_string(rows) + "x" +
           std::to_string(cols));
    }
    Flatten(key, data, kMaxNesting - 1, &numbers);
    if (int64_t{stated_rows} * stated_cols != static_cast<int64_t>(numbers.size())) {
      Fail(name + " is stated as " + shape + ", but data has " + std::to_string(numbers.size()) +
           " numbers");
    }
    return numbers;
  }

  void ReadCameraMatrix(Camera* camera) const {
    const std::string key = FindKey("camera_matrix", "cameraMatrix");
    const std::vector<double> k = ReadMatrix(key.c_str(), 3, 3);
    if (k.size() != 9) {
      Fail(key + " has " + std::to_string(k.size()) + " elements, expected 9");
    }
    if (std::abs(k[6]) > kZeroTolerance || std::abs(k[7]) > kZeroTolerance ||
        std::abs(k[8] - 1) > kZeroTolerance) {
      Fail(key + ": the last row is " + ToText(k[6]) + " " + ToText(k[7]) + " " + ToText(k[8]) +
           ", expected 0 0 1");
    }
    if (std::abs(k[3]) > kZeroTolerance) {
      Fail(key + ": element 3 is " + ToText(k[3]) + ", expected 0");
    }
    if (!(k[0] > 0)) Fail(key + ": focal length fx " + ToText(k[0]) + " is not positive");
    if (!(k[4] > 0)) Fail(key + ": focal length fy " + ToText(k[4]) + " is not positive");
    if (std::abs(k[1]) > kSkewTolerance * k[0]) {
      Fail(key + ": skew " + ToText(k[1]) + " is not supported, expected 0");
    }
    camera->fx = k[0];
    camera->cx = k[2];
    camera->fy = k[4];
    camera->cy = k[5];
  }

  // The numbers of coefficients that go with the distortion model, in words that a reader of the
  // file knows.
  struct Model {
    const char* name;  // nullptr: the file states none
    DistortionModel model;
    std::vector<size_t> sizes;
  };

  Model FindModel() const {
    static const std::vector<Model> kModels = {
        {"plumb_bob", DistortionModel::kBrown, {0, 4, 5}},
        {"rational_polynomial", DistortionModel::kBrown, {8, 12, 14}},
        {"equidistant", DistortionModel::kFisheye, {4}},
        {"fisheye", DistortionModel::kFisheye, {4}}};
    const YAML::Node node = root_["distortion_model"];
    if (!node) return {nullptr, DistortionModel::kBrown, {0, 4, 5, 8, 12, 14}};
    if (node.IsScalar()) {
      for (const Model& model : kModels) {
        if (node.Scalar() == model.name) return model;
      }
    }
    Fail("distortion_model " + (node.IsScalar() ? Quoted(node.Scalar()) : std::string()) +
         " is not one of plumb_bob, rational_polynomial, equidistant, fisheye");
  }

  void ReadDistortion(Camera* camera) const {
    const Model model = FindModel();
    const std::string key = FindKey("distortion_coefficients", "distortionCoefficients");
    const std::vector<double> d = ReadMatrix(key.c_str(), 0, 0);
    if (std::find(model.sizes.begin(), model.sizes.end(), d.size()) == model.sizes.end()) {
      std::string sizes;
      for (size_t size : model.sizes) sizes += (sizes.empty() ? "" : ", ") + std::to_string(size);
      Fail(key + " has " + std::to_string(d.size()) + " elements, expected " + sizes +
           (model.name != nullptr ? std::string(" for ") + model.name : ""));
    }
    camera->model = d.empty() ? DistortionModel::kNone : model.model;
    std::copy(d.begin(), d.end(), camera->distortion.begin());
  }

  std::string path_;
  YAML::Node root_;
};

std::string MatrixText(const std::string& key, int rows, int cols, const double* values) {
  std::string text = key + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
                     "\n   cols: " + std::to_string(cols) + "\n   dt: d\n   data: [ ";
  for (int i = 0; i < rows * cols; ++i) text += (i > 0 ? ", " : "") + ToText(values[i]);
  return text + " ]\n";
}

// The fewest coefficients of a supported number that hold all that are not zero.
int CoefficientCount(const Camera& camera) {
  if (camera.model == DistortionModel::kNone) return 0;
  if (camera.model == DistortionModel::kFisheye) return 4;
  int used = 14;
  while (used > 0 && camera.distortion[used - 1] == 0) --used;
  for (int count : {5, 8, 12}) {
    if (used <= count) return count;
  }
  return 14;
}

}  // namespace

Camera ReadCamera(const std::string& path) {
  try {
    return CameraReader(path).Read();
  } catch (const YAML::Exception& error) {
    const std::string line = error.mark.is_null() ? "" : std::to_string(error.mark.line + 1) + ": ";
    Fail(ErrorCode::kParse, path,
         "is neither YAML nor JSON: " + (line.empty() ? "" : "line " + line) + error.msg);
  }
}

void WriteCamera(const Camera& camera, const std::string& path) {
  ValidateCamera(camera);
  std::string text = "%YAML:1.0\n---\n";
  if (camera.width > 0) {
    text += "image_width: " + std::to_string(camera.width) + "\n";
    text += "image_height: " + std::to_string(camera.height) + "\n";
  }
  const std::array<double, 9> k{camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
  text += MatrixText("camera_matrix", 3, 3, k.data());
  if (camera.model == DistortionModel::kFisheye) text += "distortion_model: equidistant\n";
  const int count = CoefficientCount(camera);
  text += MatrixText("distortion_coefficients", count > 0 ? 1 : 0, count, camera.distortion.data());
  WriteWholeFile(path, text);
}

}  // namespace topotag
