#include "bench/registration.h"

#include <benchmark/benchmark.h>

#include <cstdio>
#include <exception>
#include <vector>

namespace topotag::bench {

int RunBenchmarks(int argc, char** argv,
                  const std::function<void(const std::string& photos)>& add) {
  const std::string option = "--photos";
  std::string photos;
  std::vector<char*> rest;
  for (int i = 0; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == option && i + 1 < argc) {
      photos = argv[++i];
    } else if (argument.compare(0, option.size() + 1, option + "=") == 0) {
      photos = argument.substr(option.size() + 1);
    } else {
      rest.push_back(argv[i]);
    }
  }
  int count = static_cast<int>(rest.size());
  rest.push_back(nullptr);
  try {
    benchmark::Initialize(&count, rest.data());
    if (benchmark::ReportUnrecognizedArguments(count, rest.data())) return 2;
    add(photos);
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
  }
  return 0;
}

}  // namespace topotag::bench
