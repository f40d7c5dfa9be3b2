#include "tools/image_input.h"

#include <CLI/CLI.hpp>

#include "host/check.h"
#include "tools/command.h"
#include "tools/frame_source.h"
#include "topotag/error.h"
#include "topotag/image_file.h"

namespace topotag::tools {
namespace {

constexpr uint64_t kMostPixels = uint64_t{kMaxImageSide} * kMaxImageSide;

[[noreturn]] void FailTooLarge(const std::string& reason) {
  throw Error(ErrorCode::kTooLarge, reason + "; --max-pixels raises it");
}

}  // namespace

CLI::Option* AddMaxPixels(CLI::App* command, const char* group, std::string* value) {
  const std::string help =
      "Refuse to read larger images (default: " + std::to_string(kDefaultMaxPixels) + ")";
  return AddText(command, group, "--max-pixels", value, "N", help.c_str());
}

uint64_t ParseMaxPixels(const std::string& text) {
  if (text.empty()) return kDefaultMaxPixels;
  const uint64_t pixels = ParseUnsigned("--max-pixels", text);
  if (pixels < 1 || pixels > kMostPixels) {
    throw UsageError("--max-pixels: " + text + " is not a number of pixels, 1 to " +
                     std::to_string(kMostPixels));
  }
  return pixels;
}

void CheckPixels(int width, int height, uint64_t max_pixels) {
  if (static_cast<uint64_t>(width) * static_cast<uint64_t>(height) <= max_pixels) return;
  FailTooLarge("too large: " + Text(width, height) + " pixels, more than the limit of " +
               std::to_string(max_pixels));
}

Image ReadInput(const std::string& path, uint64_t max_pixels) {
  const QuietStderr quiet;
  return ForFile(path, [&] {
    try {
      return ReadImage(path, max_pixels);
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kTooLarge) FailTooLarge(error.what());
      throw;
    }
  });
}

}  // namespace topotag::tools
