#ifndef TOPOTAG_TOOLS_DETECT_ARGUMENTS_H_
#define TOPOTAG_TOOLS_DETECT_ARGUMENTS_H_

#include <string>
#include <vector>

#include "tools/command.h"
#include "topotag/options.h"

namespace topotag::tools {

/// The command line of detect as it was typed.
struct DetectArguments {
  std::vector<std::string> inputs;
  std::string family = "3x3,4x4,5x5";
  std::string camera;
  std::vector<std::string> tag_sizes;
  std::vector<std::string> objects;
  std::string roi;
  std::string backend = "auto";
  std::string threads = std::to_string(DefaultThreads());
  std::string device;
  std::string max_pixels;
  std::string preset = "default";
  std::string far = "off";
  std::vector<std::string> ids;
  std::string hidden_nodes = "0";
  bool pre_blur = false;
  bool inverted = false;
  std::string min_size = "0";
  std::string quality = "off";
  std::string track = "off";
  std::string pose = "vertices";
  std::string format = "text";
  std::string output;
  std::string draw;
  std::string stages;
};

/// Declares them; parsing the command line fills them in.
void AddDetectArguments(CLI::App* command, DetectArguments* arguments);

/// Those that are the detector's.
/// @throws UsageError that names the argument; Error as ReadCamera
Options ParseOptions(const DetectArguments& arguments);

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_DETECT_ARGUMENTS_H_
