#ifndef TOPOTAG_BENCH_COMMAND_H_
#define TOPOTAG_BENCH_COMMAND_H_

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

namespace topotag::bench {

inline void AddFormat(CLI::App* app, std::string* format) {
  app->add_option("--format", *format, "text or json (default: text)")
      ->check(CLI::IsMember({"text", "json"}));
}

/// A benchmark's exit status; an exception is one line on stderr and status 1.
inline int RunCommand(const char* name, int (*command)(int, char**), int argc, char** argv) {
  try {
    return command(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
  }
  return 1;
}

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_COMMAND_H_
