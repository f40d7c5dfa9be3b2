#ifndef TOPOTAG_TESTS_FUZZ_TARGET_H_
#define TOPOTAG_TESTS_FUZZ_TARGET_H_

// A fuzz target: any bytes are an input, and none may crash, trip a sanitizer or abort. libFuzzer
// runs it, or standalone.cc where there is no libFuzzer.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "host/one_line.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace topotag::fuzz {

/// Inputs to begin with, made by the target itself.
std::vector<std::string> Seeds();

/// A finding.
[[noreturn]] inline void Abort(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}

inline void Require(bool condition, const char* what) {
  if (!condition) Abort(what);
}

/// From here on the process sees no OpenCL device: a driver has threads and leaks of its own.
inline void HideDevices() {
  static const int result = setenv("OCL_ICD_VENDORS", "/nonexistent", 1);
  Require(result == 0, "the environment cannot be changed");
}

/// A message for the user is one line, and no terminal takes orders from it.
inline void RequireOneLine(const std::string& message) {
  if (message.empty()) Abort("an error without a message");
  if (OneLine(message) != message) Abort("a message with control characters: " + message);
}

}  // namespace topotag::fuzz

#endif  // TOPOTAG_TESTS_FUZZ_TARGET_H_
