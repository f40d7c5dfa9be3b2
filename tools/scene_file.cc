#include "tools/scene_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/file.h"
#include "host/rotation.h"
#include "tools/command.h"
#include "tools/image_input.h"
#include "tools/json_node.h"
#include "tools/scene_conditions.h"
#include "topotag/camera_file.h"
#include "topotag/error.h"

namespace topotag::tools {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxFileSize = size_t{1} << 24;
constexpr int kMaxNesting = 8;

/// A file that the scene names: of its own folder or below, by whatever links, so that somebody
/// else's scene cannot have any file of this machine read.
std::string FileOf(const std::string& scene, const std::string& name, SceneFile* file) {
  std::error_code error;
  const fs::path folder = fs::absolute(scene, error).parent_path();
  const fs::path real_folder = fs::weakly_canonical(folder, error);
  const fs::path real = error ? fs::path() : fs::weakly_canonical(folder / name, error);
  if (error ||
      std::mismatch(real_folder.begin(), real_folder.end(), real.begin(), real.end()).first !=
          real_folder.end()) {
    throw Error(ErrorCode::kParse, "'" + name + "' is not a file of the scene's folder or below");
  }
  file->files.push_back((fs::path(scene).parent_path() / name).string());
  return file->files.back();
}

void ReadDistortion(const JsonNode& node, Camera* camera) {
  if (!node.Has("distortion")) {
    if (node.Text("distortion_model", "none") != "none")
      Fail(node.Where("distortion"), "is missing");
    return;
  }
  const Json& list = node.Get("distortion");
  const std::string where = node.Where("distortion");
  if (!list.is_array()) Fail(where, "is not a list of numbers");
  const std::string model = node.Text("distortion_model", "brown");
  const size_t count = list.size();
  if (model == "brown") {
    const bool known =
        count == 0 || count == 4 || count == 5 || count == 8 || count == 12 || count == 14;
    if (!known) Fail(where, "has not 0, 4, 5, 8, 12 or 14 numbers");
    camera->model = count == 0 ? DistortionModel::kNone : DistortionModel::kBrown;
  } else if (model == "fisheye" || model == "equidistant") {
    if (count != 4) Fail(where, "has not 4 numbers");
    camera->model = DistortionModel::kFisheye;
  } else if (model != "none" || count != 0) {
    Fail(node.Where("distortion_model"), "'" + model + "' is not one of none, brown, fisheye");
  }
  for (size_t i = 0; i < count; ++i) camera->distortion[i] = JsonNode::ToNumber(list[i], where);
}

Camera ReadInlineCamera(const JsonNode& node) {
  node.AllowOnly({"width", "height", "fx", "fy", "cx", "cy", "distortion_model", "distortion"});
  const auto side = [&node](const char* key) {
    const uint64_t value = node.Whole(key);
    if (value < 1 || value > static_cast<uint64_t>(kMaxImageSide)) {
      Fail(node.Where(key), "is not within 1 .. " + std::to_string(kMaxImageSide));
    }
    return static_cast<int>(value);
  };
  Camera camera;
  camera.width = side("width");
  camera.height = side("height");
  camera.fx = node.Number("fx");
  camera.fy = node.Number("fy");
  camera.cx = node.Number("cx");
  camera.cy = node.Number("cy");
  ReadDistortion(node, &camera);
  ValidateCamera(camera);
  return camera;
}

Matrix3 ReadRotation(const JsonNode& node) {
  if (node.Has("rvec") && node.Has("R")) Fail(node.Where("R"), "stands beside rvec: give one");
  if (node.Has("rvec")) return RotationMatrix(node.Vector("rvec"));
  Matrix3 rotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  if (!node.Has("R")) return rotation;
  const Json& rows = node.Get("R");
  const std::string where = node.Where("R");
  if (!rows.is_array() || rows.size() != 3) Fail(where, "is not a list of 3 rows");
  for (size_t i = 0; i < 3; ++i) rotation[i] = JsonNode::ToVector(rows[i], where);
  const auto dot = [&](int a, int b) {
    return rotation[a][0] * rotation[b][0] + rotation[a][1] * rotation[b][1] +
           rotation[a][2] * rotation[b][2];
  };
  const Vector3& x = rotation[0];
  const Vector3& y = rotation[1];
  const Vector3& z = rotation[2];
  const double handed = (x[1] * y[2] - x[2] * y[1]) * z[0] + (x[2] * y[0] - x[0] * y[2]) * z[1] +
                        (x[0] * y[1] - x[1] * y[0]) * z[2];
  bool is_rotation = handed > 0;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) is_rotation &= std::fabs(dot(a, b) - (a == b ? 1 : 0)) < 1e-6;
  }
  if (!is_rotation) Fail(where, "is not a rotation matrix");
  return rotation;
}

SceneMarker ReadMarker(const std::string& path, const JsonNode& node, SceneFile* file) {
  node.AllowOnly({"family", "id", "size", "inner", "outer", "frame", "margin", "inverted", "black",
                  "white", "growth", "rvec", "R", "t", "velocity", "angular_velocity"});
  SceneMarker marker;
  MarkerDesign& design = marker.design;
  design.family = At(node.Where("family"), [&] { return Family::Parse(node.Text("family")); });
  design.id = node.Whole("id");
  At(node.Where("id"), [&] { CheckId(design.family, design.id); });
  design.inner =
      At(node.Where("inner"), [&] { return ParseInnerShape(node.Text("inner", "square")); });
  const std::string outer = node.Text("outer", "square");
  At(node.Where("outer"), [&] {
    if (!SetNamedOuterShape(outer, &design)) SetOuterShape(FileOf(path, outer, file), &design);
  });
  design.frame = node.Number("frame", design.frame);
  design.margin = node.Number("margin", design.margin);
  design.inverted = node.Flag("inverted", false);
  marker.tag_size = node.Number("size");
  if (!(marker.tag_size > 0)) Fail(node.Where("size"), "is not greater than 0");
  marker.black = node.Number("black", marker.black);
  marker.white = node.Number("white", marker.white);
  marker.growth = node.Number("growth", marker.growth);
  marker.R = ReadRotation(node);
  marker.t = node.Vector("t");
  if (node.Has("velocity")) marker.velocity = node.Vector("velocity");
  if (node.Has("angular_velocity")) marker.angular_velocity = node.Vector("angular_velocity");
  return marker;
}

Json ParseFile(const std::string& path) {
  const std::string text =
      At(path + ": cannot read scene", [&] { return ReadText(path, kMaxFileSize); });
  try {
    const auto check = [](int depth, Json::parse_event_t, Json&) {
      if (depth > kMaxNesting) throw Error(ErrorCode::kParse, "is nested too deeply");
      return true;
    };
    return At(path, [&] { return Json::parse(text, check); });
  } catch (const Json::exception& error) {
    // "[json.exception.parse_error.101] parse error at line 1, ...": the tag says nothing.
    const std::string message = error.what();
    const size_t tag = message.find("] ");
    Fail(path, tag == std::string::npos ? message : message.substr(tag + 2));
  }
}

}  // namespace

void SceneFile::SetBackground(const std::string& path, uint64_t max_pixels) {
  background = ReadInput(path, max_pixels);
  scene.background_image = background.view();
}

SceneFile ReadScene(const std::string& path, uint64_t max_pixels) {
  const Json json = ParseFile(path);
  const JsonNode node(json, path);
  node.AllowOnly({"camera", "background", "blur", "noise", "seed", "markers", "exposure",
                  "row_time", "lighting", "occluders"});
  SceneFile file;
  Scene& scene = file.scene;
  const Json& camera = node.Get("camera");
  scene.camera = At(node.Where("camera"), [&] {
    if (camera.is_object()) return ReadInlineCamera(JsonNode(camera, "object"));
    return ReadCamera(FileOf(path, node.Text("camera"), &file));
  });
  if (node.Has("background") && node.Get("background").is_string()) {
    At(node.Where("background"),
       [&] { file.SetBackground(FileOf(path, node.Text("background"), &file), max_pixels); });
  } else {
    scene.background = node.Number("background", scene.background);
  }
  scene.blur = node.Number("blur", scene.blur);
  scene.noise = node.Number("noise", scene.noise);
  if (node.Has("seed")) scene.seed = node.Whole("seed");
  const Json& markers = node.List("markers");
  for (size_t i = 0; i < markers.size(); ++i) {
    const std::string where = path + ": marker " + std::to_string(i);
    scene.markers.push_back(ReadMarker(path, JsonNode(markers[i], where), &file));
  }
  ReadConditions(node, &scene);
  return file;
}

Matrix3 RotationMatrix(const Vector3& rvec) { return Exp(rvec); }

}  // namespace topotag::tools
