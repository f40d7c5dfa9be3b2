#include "bench/machine.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <ctime>
#include <fstream>
#include <string>
#include <thread>

#include "tools/compiler.h"
#include "topotag/detector.h"

namespace topotag::bench {
namespace {

/// Linux's; "" elsewhere.
std::string Processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const size_t colon = line.find(": ");
    if (line.compare(0, 10, "model name") == 0 && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
  return "";
}

std::string Now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &utc);
  return text;
}

}  // namespace

nlohmann::ordered_json DescribeMachine() {
  nlohmann::ordered_json machine;
  machine["date"] = Now();
  machine["topotag"] = Version();
  machine["compiler"] = kCompiler;
  if (const std::string processor = Processor(); !processor.empty()) {
    machine["processor"] = processor;
  }
  machine["cores"] = std::thread::hardware_concurrency();
#ifdef _SC_LEVEL3_CACHE_SIZE
  const auto cache = [&machine](const char* name, int key) {
    if (const long bytes = sysconf(key); bytes > 0) machine[name] = bytes / 1024;
  };
  cache("l1d_kib", _SC_LEVEL1_DCACHE_SIZE);
  cache("l2_kib", _SC_LEVEL2_CACHE_SIZE);
  cache("l3_kib", _SC_LEVEL3_CACHE_SIZE);
#endif
  utsname system{};
  if (uname(&system) == 0) {
    machine["system"] = std::string(system.sysname) + " " + system.release + " " + system.machine;
  }
  return machine;
}

}  // namespace topotag::bench
