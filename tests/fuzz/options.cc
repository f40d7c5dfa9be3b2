// Values of command-line options: wrong usage of one line or a command that runs, and ends where
// it would open its input or its output. Options that name a file get one of a few: no other file
// is read, none is written.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/fuzz/input.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/target.h"
#include "tools/command.h"
#include "topotag/error.h"

namespace topotag::fuzz {
namespace {

constexpr size_t kMaxOptions = 16;
constexpr char kMissing[] = "/nonexistent/topotag";

/// A command with its options, the words that name it, and what runs it.
struct Subject {
  CLI::App* app;
  std::vector<const char*> words;
  tools::Command run;
};

/// The files that options may name.
class Files {
 public:
  Files() {
    camera_.Set(
        "image_width: 64\nimage_height: 48\n"
        "camera_matrix: [60, 0, 31.5, 0, 60, 23.5, 0, 0, 1]\n"
        "distortion_coefficients: [-0.1, 0, 0, 0]\n");
    object_.Set("4x4 278 0.05 0 0 0 0 0 0\n3x3 5 0.04 0.1 0 0 0 0 0\n");
    polygon_.Set("-10 -10\n10 -10\n10 10\n-10 10\n");
  }
  /// By a letter; for others the file that belongs to the option.
  std::string Choose(const std::string& option, char letter) const {
    if (letter == 'x') return kMissing;
    if (letter == 'd') return "/";
    if (letter == 'o' || option == "--object") return object_.path();
    return letter == 'p' || option == "--outer" ? polygon_.path() : camera_.path();
  }

 private:
  MemoryFile camera_, object_, polygon_;
};

bool NamesFile(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type.find("FILE") != std::string::npos || type.find("DIR") != std::string::npos;
}

// Else its value is something else.
bool MayNameFile(const CLI::Option& option) {
  return option.check_name("--outer") || option.check_name("--background");
}

bool IsOutput(const CLI::Option& option) {
  for (const char* name : {"--output", "--draw", "--stages", "--truth", "--write-camera"}) {
    if (option.check_name(name)) return true;
  }
  return false;
}

bool IsGiven(const std::string& name, const std::vector<std::string>& arguments) {
  return std::any_of(arguments.begin(), arguments.end(), [&](const std::string& argument) {
    return argument.compare(0, name.size() + 1, name + "=") == 0;
  });
}

/// One option with its value. What may stand once does.
void AddOption(const std::vector<CLI::Option*>& options, const Files& files, Input* input,
               std::vector<std::string>* arguments) {
  const CLI::Option& option = *options[input->Byte() % options.size()];
  // Without a name: the inputs, which are added last.
  if (!option.nonpositional()) return;
  if (option.check_name("--help") || IsOutput(option)) return;
  const std::string name = option.get_name();
  if (option.get_items_expected_max() == 0) {  // a flag
    arguments->push_back(name);
    return;
  }
  std::string value = input->Until('\n');
  if (option.get_expected_max() == 1 && IsGiven(name, *arguments)) return;
  // What is typed holds no NUL; with a slash, a value could name any file.
  std::replace(value.begin(), value.end(), '\0', ' ');
  std::replace(value.begin(), value.end(), '/', ' ');
  const char letter = value.size() == 1 ? value[0] : '\0';
  if (NamesFile(option) || (MayNameFile(option) && letter != '\0')) {
    value = files.Choose(name, letter);
  }
  if (value.empty()) {
    arguments->insert(arguments->end(), {name, value});
  } else {
    arguments->push_back(name + "=" + value);
  }
}

std::vector<std::string> Arguments(const Subject& subject, const Files& files, Input* input) {
  const std::vector<CLI::Option*> options = subject.app->get_options();
  std::vector<std::string> arguments(subject.words.begin(), subject.words.end());
  for (size_t i = 0; i < kMaxOptions && input->left() > 0; ++i) {
    AddOption(options, files, input, &arguments);
  }
  // What a command cannot do without.
  for (const CLI::Option* option : options) {
    const std::string name = option->get_name();
    const bool is_needed =
        option->get_required() || (name == "--camera" && subject.app->get_name() == "render");
    if (!is_needed || IsGiven(name, arguments)) continue;
    if (IsOutput(*option)) {
      arguments.push_back(name + "=" + kMissing + "/out.svg");
    } else if (option->get_positional()) {
      arguments.push_back("camera:x");  // no such input: a usage error after all options
    } else if (NamesFile(*option)) {
      arguments.push_back(name + "=" + files.Choose(name, 0));
    } else {
      arguments.push_back(name + "=" + (name == "--family" ? "4x4" : "2"));
    }
  }
  return arguments;
}

void Run(Input* input) {
  static const Files files;
  CLI::App app("", "topotag");
  app.require_subcommand(0, 1);
  std::vector<Subject> subjects;
  const auto add = [&](const char* name, tools::Command run) {
    subjects.push_back({app.get_subcommand(name), {name}, std::move(run)});
  };
  add("detect", tools::AddDetect(&app));
  add("generate", tools::AddGenerate(&app));
  add("render", tools::AddRender(&app));
  const tools::Command object = tools::AddObject(&app);
  for (CLI::App* part : app.get_subcommand("object")->get_subcommands({})) {
    subjects.push_back({part, {"object", part->get_name().c_str()}, object});
  }
  const Subject& subject = subjects[input->Byte() % subjects.size()];
  std::vector<std::string> arguments = Arguments(subject, files, input);
  // CLI11 takes them from the back.
  std::reverse(arguments.begin(), arguments.end());
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError&) {
    return;
  }
  subject.run();
}

std::vector<std::string> Words(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

// The index of a command and of an option, as Run and AddOption find them.
std::string Seed(char command, const std::vector<std::pair<char, std::string>>& options) {
  std::string seed(1, command);
  for (const auto& [option, value] : options) seed += option + value + "\n";
  return seed;
}

}  // namespace

// Every value for every option of every command: which option a byte names, the commands decide.
std::vector<std::string> Seeds() {
  const std::vector<std::string> values = Words(
      "3x3,4x4 8x8 0-9,12 4x4:0-99,278 0.05 12 1e-3 0,0,64,48 opencl scalar paper on json circle "
      "hexagon butterfly letter svg x o p 3x3:5 0,0,0.4,0.5,0,0 photometric 4611686018427387903");
  std::vector<std::string> seeds;
  for (char command = 0; command < 6; ++command) {
    for (char option = 1; option < 20; ++option) {
      const size_t first = static_cast<size_t>(7 * option + command) % values.size();
      std::vector<std::pair<char, std::string>> options;
      for (size_t i = 0; i < 5; ++i) {
        options.emplace_back(static_cast<char>(option + 3 * static_cast<int>(i)),
                             values[(first + i) % values.size()]);
      }
      seeds.push_back(Seed(command, options));
    }
  }
  return seeds;
}

}  // namespace topotag::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace topotag;
  fuzz::HideDevices();
  fuzz::Input input(data, size);
  try {
    fuzz::Run(&input);
  } catch (const tools::UsageError& error) {
    fuzz::RequireOneLine(error.what());
  } catch (const Error& error) {
    fuzz::RequireOneLine(error.what());
  }
  return 0;
}
