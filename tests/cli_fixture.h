#ifndef TOPOTAG_TESTS_CLI_FIXTURE_H_
#define TOPOTAG_TESTS_CLI_FIXTURE_H_

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"

namespace topotag {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

inline std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void WriteFile(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

inline std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

inline std::vector<std::string> Keys(const Json& json) {
  std::vector<std::string> keys;
  for (const auto& item : json.items()) keys.push_back(item.key());
  return keys;
}

inline std::vector<std::string> Names(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

struct Outcome {
  int status = -1;
  std::string out;
  std::string err;
};

using Strings = std::vector<std::string>;

/// Each test has a folder of its own, in which the commands run.
class CliTest : public testing::Test {
 protected:
  void SetUp() override { fs::create_directory(folder_ / "in"); }

  /// Runs a shell command line in the test's folder.
  Outcome Shell(const std::string& line) const {
    const std::string command =
        "cd '" + folder_.string() + "' && { " + line + "\n} >.stdout 2>.stderr";
    const int status = std::system(command.c_str());
    Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadFile(folder_ / ".stdout"),
                    ReadFile(folder_ / ".stderr")};
    fs::remove(folder_ / ".stdout");
    fs::remove(folder_ / ".stderr");
    return outcome;
  }
  Outcome Run(const std::string& arguments) const {
    return Shell(std::string("'") + TOPOTAG_CLI + "' " + arguments);
  }

  /// Fails with one line on stderr that holds all of `parts`.
  void ExpectComplaint(const std::string& arguments, int status, const Strings& parts) const {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.status, status) << arguments << "\n" << outcome.err;
    ASSERT_EQ(Lines(outcome.err).size(), 1u) << arguments << "\n" << outcome.err;
    EXPECT_EQ(outcome.err.compare(0, 9, "topotag: "), 0) << outcome.err;
    for (const std::string& part : parts) {
      EXPECT_NE(outcome.err.find(part), std::string::npos) << part << " in " << outcome.err;
    }
  }

  /// scene.png, truth.json and cam.yaml: three markers, a lens with distortion.
  void RenderScene() const {
    WriteFile(folder_ / "scene.json", R"({
      "camera": {"width": 640, "height": 480, "fx": 600, "fy": 605, "cx": 322, "cy": 237,
                 "distortion": [-0.1, 0.02, 0.001, -0.001, 0]},
      "background": 90, "blur": 0.7, "noise": 1, "seed": 7,
      "markers": [
        {"family": "4x4", "id": 278, "size": 0.05, "rvec": [0.4, 0.1, 0.3], "t": [0.06, 0.03, 0.25]},
        {"family": "3x3", "id": 46, "size": 0.05, "inner": "circle", "outer": "circle",
         "rvec": [0, -0.5, 2], "t": [-0.06, -0.02, 0.25]},
        {"family": "3x3", "id": 1, "size": 0.05, "inner": "hexagon",
         "R": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "t": [-0.05, 0.08, 0.3]}]})");
    const Outcome outcome =
        Run("render scene.json -o scene.png --truth truth.json --write-camera cam.yaml");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    ASSERT_EQ(outcome.out + outcome.err, "");
  }

  Json Detect(const std::string& arguments) const {
    const Outcome outcome = Run("detect --format json " + arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    return Json::parse(outcome.out);
  }

  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

}  // namespace topotag

#endif  // TOPOTAG_TESTS_CLI_FIXTURE_H_
