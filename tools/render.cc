#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <tuple>

#include "tools/command.h"
#include "tools/image_input.h"
#include "tools/output.h"
#include "tools/report.h"
#include "tools/scene_file.h"
#include "topotag/camera_file.h"
#include "topotag/error.h"
#include "topotag/image_file.h"

namespace topotag::tools {
namespace {

/// The command line as it was typed.
struct Arguments {
  std::string scene;
  std::string camera;
  std::vector<std::string> markers;
  std::vector<std::string> poses;
  std::string tag_size;
  std::string blur;
  std::string noise;
  std::string seed;
  std::string background;
  std::string max_pixels;
  std::string output;
  std::string truth;
  std::string write_camera;
};

SceneMarker ParseMarker(const std::string& marker, const std::string& pose, double tag_size) {
  const size_t colon = marker.find(':');
  if (colon == std::string::npos) {
    throw UsageError("--marker: '" + marker + "' is not FAMILY:ID");
  }
  SceneMarker result;
  result.design.family =
      ForOption("--marker", [&] { return Family::Parse(marker.substr(0, colon)); });
  result.design.id = ParseUnsigned("--marker", marker.substr(colon + 1));
  ForOption("--marker", [&] {
    CheckId(result.design.family, result.design.id);
    return 0;
  });
  const std::vector<double> values = ParseNumbers("--pose", pose, 6);
  result.tag_size = tag_size;
  result.t = {values[0], values[1], values[2]};
  result.R = RotationMatrix({values[3], values[4], values[5]});
  return result;
}

/// The scene of --camera, --marker, --tag-size and --pose.
void ParseScene(const Arguments& arguments, Scene* scene) {
  if (arguments.camera.empty()) {
    throw UsageError("--camera: is missing (or give a scene file)");
  }
  scene->camera = ForOption("--camera", [&] { return ReadCamera(arguments.camera); });
  if (arguments.markers.size() != arguments.poses.size()) {
    throw UsageError("--pose: given " + std::to_string(arguments.poses.size()) + " times for " +
                     std::to_string(arguments.markers.size()) + " --marker");
  }
  if (!arguments.markers.empty() && arguments.tag_size.empty()) {
    throw UsageError("--tag-size: is missing");
  }
  const double tag_size =
      arguments.tag_size.empty() ? 0 : ParsePositive("--tag-size", arguments.tag_size);
  for (size_t i = 0; i < arguments.markers.size(); ++i) {
    scene->markers.push_back(ParseMarker(arguments.markers[i], arguments.poses[i], tag_size));
  }
}

void RejectSceneOptions(const Arguments& arguments) {
  const std::pair<const char*, bool> given[] = {{"--camera", !arguments.camera.empty()},
                                                {"--marker", !arguments.markers.empty()},
                                                {"--pose", !arguments.poses.empty()},
                                                {"--tag-size", !arguments.tag_size.empty()}};
  for (const auto& [option, is_given] : given) {
    if (is_given) throw UsageError(std::string(option) + ": does not go with a scene file");
  }
}

/// What stands on the command line overrides the scene file.
void ApplyOverrides(const Arguments& arguments, uint64_t max_pixels, SceneFile* file) {
  Scene& scene = file->scene;
  if (!arguments.blur.empty()) scene.blur = ParseNotNegative("--blur", arguments.blur);
  if (!arguments.noise.empty()) scene.noise = ParseNotNegative("--noise", arguments.noise);
  if (!arguments.seed.empty()) scene.seed = ParseUnsigned("--seed", arguments.seed);
  if (arguments.background.empty()) return;
  char* end = nullptr;
  std::strtod(arguments.background.c_str(), &end);
  if (*end == '\0') {
    scene.background = ParseNotNegative("--background", arguments.background);
    if (scene.background > 255) throw UsageError("--background: is more than 255");
    scene.background_image = {};
  } else {
    file->SetBackground(arguments.background, max_pixels);
  }
}

std::string TruthLine(const Arguments& arguments, const Scene& scene) {
  std::vector<Detection> detections;
  for (size_t i = 0; i < scene.markers.size(); ++i) {
    detections.push_back(GroundTruth(scene, static_cast<int>(i)));
  }
  // The order of the detector's results.
  std::sort(detections.begin(), detections.end(), [](const Detection& a, const Detection& b) {
    return std::make_tuple(a.family.n(), a.id, a.center.y, a.center.x) <
           std::make_tuple(b.family.n(), b.id, b.center.y, b.center.x);
  });
  nlohmann::ordered_json json =
      FrameJson(arguments.output, 0, scene.camera.width, scene.camera.height);
  json["detections"] = nlohmann::ordered_json::array();
  for (const Detection& detection : detections) {
    nlohmann::ordered_json marker = MarkerJson(detection);
    marker["pose"] = TransformJson(*detection.pose);
    json["detections"].push_back(std::move(marker));
  }
  return Dump(json) + "\n";
}

int RunRender(const Arguments& arguments) {
  const uint64_t max_pixels = ParseMaxPixels(arguments.max_pixels);
  SceneFile file;
  if (arguments.scene.empty()) {
    ParseScene(arguments, &file.scene);
  } else {
    RejectSceneOptions(arguments);
    file = ReadScene(arguments.scene, max_pixels);
  }
  std::vector<std::string> inputs = file.files;
  inputs.insert(inputs.end(), {arguments.scene, arguments.camera, arguments.background});
  CheckOutputs({{"-o", arguments.output},
                {"--truth", arguments.truth},
                {"--write-camera", arguments.write_camera}},
               inputs);
  ApplyOverrides(arguments, max_pixels, &file);
  const std::string source =
      arguments.scene.empty() ? "--camera " + arguments.camera : arguments.scene;
  if (file.scene.camera.width == 0 || file.scene.camera.height == 0) {
    throw Error(ErrorCode::kInvalidArgument, source + ": the camera's image size is missing");
  }
  Image image;
  try {
    image = RenderScene(file.scene);
  } catch (const Error& error) {
    if (arguments.scene.empty()) throw UsageError(error.what());
    throw Error(error.code(), Named(source, error.what()));
  }
  ForFile(arguments.output, [&] { WriteImage(image.view(), arguments.output); });
  if (!arguments.truth.empty()) {
    WriteOutput(arguments.truth, TruthLine(arguments, file.scene));
  }
  if (!arguments.write_camera.empty()) {
    ForFile(arguments.write_camera,
            [&] { WriteCamera(file.scene.camera, arguments.write_camera); });
  }
  return kSuccess;
}

}  // namespace

Command AddRender(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("render", "Draw markers as a camera sees them, with ground truth");
  const auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  command->add_option("SCENE", a.scene, "Scene file (JSON)")->type_name("");
  AddText(command, "Without a scene file", "--camera", &a.camera, "FILE",
          "Calibration with its image size, as for detect");
  command->add_option("--marker", a.markers, "A marker; repeat it, each with its --pose")
      ->type_name("FAMILY:ID")
      ->allow_extra_args(false)
      ->group("Without a scene file");
  command
      ->add_option("--pose", a.poses,
                   "Position in metres and rotation vector in radians, in the camera's axes")
      ->type_name("TX,TY,TZ,RX,RY,RZ")
      ->allow_extra_args(false)
      ->group("Without a scene file");
  AddText(command, "Without a scene file", "--tag-size", &a.tag_size, "METRES",
          "Side of the white area in metres");
  AddText(command, "Picture", "--blur", &a.blur, "PIXELS", "Sigma of the blur (default: 0.7)");
  AddText(command, "Picture", "--noise", &a.noise, "LEVELS",
          "Sigma of the noise, grey levels (default: 2)");
  AddText(command, "Picture", "--seed", &a.seed, "N", "Seed of the noise (default: 1)");
  AddText(command, "Picture", "--background", &a.background, "LEVEL|IMAGE",
          "Grey level, 0 .. 255, or a picture (default: 90)");
  AddMaxPixels(command, "Picture", &a.max_pixels);
  AddText(command, "Output", "-o,--output", &a.output, "FILE",
          "The picture: .png, .jpg, .bmp, .pgm, .tif or .webp")
      ->required();
  AddText(command, "Output", "--truth", &a.truth, "FILE",
          "Exact IDs, vertices and poses, in the form of topotag detect --format json");
  AddText(command, "Output", "--write-camera", &a.write_camera, "FILE",
          "The scene's camera as OpenCV YAML");
  command->footer(
      "Where there is a scene file, the defaults are what it says. Only there:\n"
      "  a marker's growth, velocity, angular_velocity; exposure, row_time;\n"
      "  lighting {gain, gradient, vignetting, shadow {point, angle, factor,\n"
      "  penumbra}, highlights [{center, sigma, level}]};\n"
      "  occluders [{outline, level, marker}]\n"
      "Examples:\n"
      "  topotag render scene.json -o out.png --truth t.json --write-camera cam.yaml\n"
      "  topotag render --camera cam.yaml --marker 4x4:278 --tag-size 0.05 \\\n"
      "      --pose 0,0,0.4,0.5,0,0 -o out.png");
  return [arguments] { return RunRender(*arguments); };
}

}  // namespace topotag::tools
