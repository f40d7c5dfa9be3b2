#include "host/jpeg.h"

#include <csetjmp>
#include <cstdio>
#include <string>

// Needs <cstdio> above it.
#include <jpeglib.h>
// Needs jpeglib.h above it.
#include <jerror.h>

#include "host/encoded_image.h"
#include "topotag/error.h"

namespace topotag {
namespace {

// A message of libjpeg ends the step in which it comes up.
struct ErrorManager {
  jpeg_error_mgr base;  // first, so that libjpeg's pointer to it is one to the whole
  jmp_buf escape;
  char message[JMSG_LENGTH_MAX];
};

[[noreturn]] void Escape(j_common_ptr jpeg) {
  auto* errors = reinterpret_cast<ErrorManager*>(jpeg->err);
  errors->base.format_message(jpeg, errors->message);
  longjmp(errors->escape, 1);
}

// Of libjpeg's warnings those after which pixels are wrong; others, such as unused bytes between
// two markers, are common in files of cameras.
void Warn(j_common_ptr jpeg, int level) {
  if (level >= 0) return;
  switch (jpeg->err->msg_code) {
#ifdef D_ARITH_CODING_SUPPORTED
    case JWRN_ARITH_BAD_CODE:
#endif
    case JWRN_HIT_MARKER:
    case JWRN_HUFF_BAD_CODE:
    case JWRN_JPEG_EOF:
    case JWRN_MUST_RESYNC:
      Escape(jpeg);
    default:
      break;
  }
}

// Each step returns false where libjpeg gives up. It leaves by longjmp: no object with a
// destructor is created between setjmp and there.
class Decoder {
 public:
  Decoder() {
    jpeg_.err = jpeg_std_error(&errors_.base);
    errors_.base.error_exit = Escape;
    errors_.base.emit_message = Warn;
    errors_.message[0] = '\0';
  }
  ~Decoder() { jpeg_destroy_decompress(&jpeg_); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  const char* message() const { return errors_.message; }
  bool is_cmyk() const { return jpeg_.out_color_space == JCS_CMYK; }
  int width() const { return static_cast<int>(jpeg_.image_width); }
  int height() const { return static_cast<int>(jpeg_.image_height); }

  bool ReadHeader(const std::vector<uint8_t>& bytes) {
    if (setjmp(errors_.escape) != 0) return false;
    jpeg_create_decompress(&jpeg_);
    jpeg_mem_src(&jpeg_, bytes.data(), bytes.size());
    jpeg_read_header(&jpeg_, TRUE);
    return true;
  }

  bool Start() {
    if (setjmp(errors_.escape) != 0) return false;
    jpeg_.out_color_space = jpeg_.num_components == 4 ? JCS_CMYK : JCS_GRAYSCALE;
    jpeg_start_decompress(&jpeg_);
    return true;
  }

  bool ReadRow(uint8_t* row) {
    if (setjmp(errors_.escape) != 0) return false;
    jpeg_read_scanlines(&jpeg_, &row, 1);
    return true;
  }

  bool Finish() {
    if (setjmp(errors_.escape) != 0) return false;
    jpeg_finish_decompress(&jpeg_);
    return true;
  }

 private:
  jpeg_decompress_struct jpeg_{};
  ErrorManager errors_;
};

// Files with four inks hold them inverted, as Adobe's programs write them: 255 = no ink.
void CmykToLuminance(const std::vector<uint8_t>& inks, int width, uint8_t* row) {
  for (int x = 0; x < width; ++x) {
    const uint8_t* ink = inks.data() + 4 * static_cast<size_t>(x);
    const uint64_t k = ink[3];
    row[x] = Luminance(ink[0] * k, ink[1] * k, ink[2] * k, 255 * 255);
  }
}

}  // namespace

Image DecodeJpeg(const std::vector<uint8_t>& bytes, uint64_t max_pixels) {
  Decoder decoder;
  const auto check = [&decoder](bool done) {
    if (!done) throw Error(ErrorCode::kFile, std::string("corrupt: ") + decoder.message());
  };
  check(decoder.ReadHeader(bytes));
  CheckImageSize(static_cast<uint64_t>(decoder.width()), static_cast<uint64_t>(decoder.height()),
                 max_pixels);
  check(decoder.Start());
  Image image(decoder.width(), decoder.height());
  std::vector<uint8_t> inks(decoder.is_cmyk() ? 4 * static_cast<size_t>(image.width()) : 0);
  for (int y = 0; y < image.height(); ++y) {
    check(decoder.ReadRow(inks.empty() ? image.row(y) : inks.data()));
    if (!inks.empty()) CmykToLuminance(inks, image.width(), image.row(y));
  }
  check(decoder.Finish());
  return image;
}

}  // namespace topotag
