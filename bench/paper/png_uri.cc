#include "bench/paper/png_uri.h"

#include <png.h>

#include <cstdint>
#include <vector>

#include "topotag/error.h"

namespace topotag::bench::paper {
namespace {

std::vector<uint8_t> EncodePng(const ImageView& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_GRAY;
  const auto stride = static_cast<png_int_32>(image.stride);
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::vector<uint8_t> bytes(size);
  if (png_image_write_to_memory(&header, bytes.data(), &size, 0, image.data, stride, nullptr) ==
      0) {
    throw Error(ErrorCode::kFile, std::string("cannot encode a picture: ") + header.message);
  }
  bytes.resize(size);
  return bytes;
}

std::string Base64(const std::vector<uint8_t>& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t j = i; j < i + 3; ++j) group = group << 8 | (j < bytes.size() ? bytes[j] : 0);
    for (size_t digit = 0; digit < 4; ++digit) {
      const bool padding = i + digit > bytes.size();
      text += padding ? '=' : kDigits[group >> (18 - 6 * digit) & 63];
    }
  }
  return text;
}

}  // namespace

std::string PngUri(const ImageView& image) {
  return "data:image/png;base64," + Base64(EncodePng(image));
}

}  // namespace topotag::bench::paper
