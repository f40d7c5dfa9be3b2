// Image files in memory: whatever they hold, a picture or an error of one line.

#include "host/encoded_image.h"

#include <unistd.h>

#include <filesystem>
#include <opencv2/core/utils/logger.hpp>
#include <string>
#include <vector>

#include "host/file.h"
#include "tests/fuzz/target.h"
#include "topotag/error.h"
#include "topotag/image_file.h"

namespace topotag::fuzz {
namespace {

// Larger pictures take longer, nothing else.
constexpr uint64_t kMaxFuzzedPixels = uint64_t{1} << 16;

Image Picture() {
  Image image(19, 13);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      image.row(y)[x] = static_cast<uint8_t>(x * y % 3 == 0 ? 200 + x : 9 * y);
    }
  }
  return image;
}

}  // namespace

std::vector<std::string> Seeds() {
  std::vector<std::string> seeds;
  const std::string stem =
      (std::filesystem::temp_directory_path() / ("fuzz_image_" + std::to_string(getpid())))
          .string();
  for (const char* extension : {".png", ".jpg", ".bmp", ".pgm", ".tif", ".webp"}) {
    WriteImage(Picture().view(), stem + extension);
    seeds.push_back(ReadText(stem + extension, size_t{1} << 20));
    std::filesystem::remove(stem + extension);
  }
  seeds.push_back("P1\n# bits\n3 2\n0 1 0\n101\n");
  seeds.push_back("P2 3 2 15\n0 1 2\n13 14 15\n");
  seeds.push_back("P3\n2 1\n65535\n0 65535 7 1 2 3\n");
  seeds.push_back("P4\n9 2\n\xaa\x80\x55\x7f");
  seeds.push_back("P6 2 1 255\nabcdef");
  return seeds;
}

}  // namespace topotag::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace topotag;
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  try {
    const Image image = DecodeImage({data, data + size}, fuzz::kMaxFuzzedPixels);
    const uint64_t width = static_cast<uint64_t>(image.width());
    const uint64_t pixels = width * static_cast<uint64_t>(image.height());
    fuzz::Require(pixels > 0, "a picture without pixels");
    fuzz::Require(pixels <= fuzz::kMaxFuzzedPixels, "a picture of more pixels than allowed");
  } catch (const Error& error) {
    fuzz::RequireOneLine(error.what());
  }
  return 0;
}
