#include "host/webp.h"

#include <webp/decode.h>

#include <new>

#include "host/encoded_image.h"
#include "topotag/error.h"

namespace topotag {
namespace {

constexpr int kChannels = 3;  // R, G, B

void Check(VP8StatusCode status) {
  if (status == VP8_STATUS_OK) return;
  if (status == VP8_STATUS_OUT_OF_MEMORY) throw std::bad_alloc();
  throw Error(ErrorCode::kFile, "cannot be decoded: corrupt, or of an unsupported variant");
}

}  // namespace

Image DecodeWebp(const std::vector<uint8_t>& bytes, uint64_t max_pixels) {
  WebPDecoderConfig config;
  if (WebPInitDecoderConfig(&config) == 0) Check(VP8_STATUS_INVALID_PARAM);
  Check(WebPGetFeatures(bytes.data(), bytes.size(), &config.input));
  if (config.input.has_animation != 0) {
    throw Error(ErrorCode::kFile, "animated WebP is not supported");
  }
  CheckImageSize(static_cast<uint64_t>(config.input.width),
                 static_cast<uint64_t>(config.input.height), max_pixels);
  Image image(config.input.width, config.input.height);
  const size_t stride = static_cast<size_t>(image.width()) * kChannels;
  std::vector<uint8_t> pixels(stride * static_cast<size_t>(image.height()));
  config.output.colorspace = MODE_RGB;
  config.output.is_external_memory = 1;
  config.output.u.RGBA = {pixels.data(), static_cast<int>(stride), pixels.size()};
  Check(WebPDecode(bytes.data(), bytes.size(), &config));
  for (int y = 0; y < image.height(); ++y) {
    const uint8_t* in = pixels.data() + static_cast<size_t>(y) * stride;
    uint8_t* out = image.row(y);
    for (int x = 0; x < image.width(); ++x, in += kChannels) {
      out[x] = Luminance(in[0], in[1], in[2], 255);
    }
  }
  return image;
}

}  // namespace topotag
