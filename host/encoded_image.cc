#include "host/encoded_image.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "topotag/error.h"

namespace topotag {
namespace {

using Bytes = std::vector<uint8_t>;

[[noreturn]] void Fail(const std::string& reason) { throw Error(ErrorCode::kFile, reason); }
[[noreturn]] void FailTruncated() { Fail("truncated"); }

bool HasPrefix(const Bytes& bytes, size_t at, const void* prefix, size_t size) {
  return bytes.size() >= at + size && std::memcmp(bytes.data() + at, prefix, size) == 0;
}

/// Unsigned integers at byte offsets. An offset beyond the end means a truncated file.
class ByteReader {
 public:
  ByteReader(const Bytes& bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}

  uint32_t Get(uint64_t at, int size) const {
    if (at + size > bytes_.size()) FailTruncated();
    uint32_t value = 0;
    for (int i = 0; i < size; ++i) {
      value = value << 8 | bytes_[at + (big_endian_ ? i : size - 1 - i)];
    }
    return value;
  }
  uint32_t U8(uint64_t at) const { return Get(at, 1); }
  uint32_t U16(uint64_t at) const { return Get(at, 2); }
  uint32_t U32(uint64_t at) const { return Get(at, 4); }

 private:
  const Bytes& bytes_;
  bool big_endian_;
};

// --- PNG ---------------------------------------------------------------------------------------

uint32_t Crc32(const uint8_t* data, size_t size) {
  static const std::array<uint32_t, 256> kTable = [] {
    std::array<uint32_t, 256> table{};
    for (uint32_t i = 0; i < 256; ++i) {
      table[i] = i;
      for (int bit = 0; bit < 8; ++bit) {
        table[i] = (table[i] & 1) != 0 ? 0xEDB88320u ^ (table[i] >> 1) : table[i] >> 1;
      }
    }
    return table;
  }();
  uint32_t crc = ~0u;
  for (size_t i = 0; i < size; ++i) crc = kTable[(crc ^ data[i]) & 255] ^ (crc >> 8);
  return ~crc;
}

constexpr uint8_t kPngSignature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};

// Keeps the critical chunks only: libpng prints warnings about others, such as colour profiles.
void CheckPng(Bytes* bytes, uint64_t max_pixels) {
  const ByteReader reader(*bytes, true);
  uint64_t in = sizeof(kPngSignature), out = in;
  for (std::string type; type != "IEND";) {
    const uint64_t size = uint64_t{12} + reader.U32(in);
    if (in + size > bytes->size()) FailTruncated();
    uint8_t* chunk = bytes->data() + in;
    type.assign(chunk + 4, chunk + 8);
    if (Crc32(chunk + 4, size - 8) != reader.U32(in + size - 4)) {
      Fail("corrupt: wrong checksum in PNG chunk " + std::to_string(in) + " bytes into the file");
    }
    const bool first = in == sizeof(kPngSignature);
    if (first != (type == "IHDR")) Fail("corrupt: misplaced PNG header chunk");
    if (first) CheckImageSize(reader.U32(in + 8), reader.U32(in + 12), max_pixels);
    const bool critical = (chunk[4] & 0x20) == 0;
    if (critical) {
      std::memmove(bytes->data() + out, chunk, size);
      out += size;
    }
    in += size;
  }
  bytes->resize(out);
}

// --- JPEG --------------------------------------------------------------------------------------

// Position of the first marker at or after `at` within entropy-coded data.
uint64_t NextJpegMarker(const Bytes& bytes, uint64_t at) {
  for (; at + 1 < bytes.size(); ++at) {
    if (bytes[at] != 0xFF) continue;
    const uint8_t code = bytes[at + 1];
    const bool restart = code >= 0xD0 && code <= 0xD7;
    if (code != 0 && code != 0xFF && !restart) return at;
  }
  FailTruncated();
}

// That nothing is cut off. The size is checked where libjpeg has read it (DecodeJpeg).
void CheckJpeg(const Bytes& bytes) {
  const ByteReader reader(bytes, true);
  for (uint64_t at = 2;;) {
    if (reader.U8(at) != 0xFF) Fail("corrupt: a JPEG marker is missing");
    const uint32_t code = reader.U8(at + 1);
    if (code == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    if (code == 0xD9) return;                              // end of image
    if (code == 0x01 || (code >= 0xD0 && code <= 0xD8)) {  // a marker alone
      at += 2;
      continue;
    }
    const uint32_t size = reader.U16(at + 2);
    if (size < 2) Fail("corrupt: empty JPEG segment");
    at += 2 + size;
    if (code == 0xDA) at = NextJpegMarker(bytes, at);  // start of scan
  }
}

// --- BMP, WebP, TIFF ---------------------------------------------------------------------------

void CheckBmp(const Bytes& bytes, uint64_t max_pixels) {
  const ByteReader reader(bytes, false);
  const uint32_t header = reader.U32(14);
  uint64_t width, height;
  uint32_t bits, compression = 0;
  if (header == 12) {
    width = reader.U16(18);
    height = reader.U16(20);
    bits = reader.U16(24);
  } else {
    if (header < 40) Fail("corrupt: BMP header of " + std::to_string(header) + " bytes");
    const auto rows = static_cast<int32_t>(reader.U32(22));  // negative: top-down
    width = reader.U32(18);
    height = rows < 0 ? uint64_t{0} - static_cast<int64_t>(rows) : rows;
    bits = reader.U16(28);
    compression = reader.U32(30);
  }
  CheckImageSize(width, height, max_pixels);
  constexpr uint32_t kUncompressed = 0, kBitFields = 3;
  if (compression > kBitFields) Fail("unsupported BMP compression " + std::to_string(compression));
  if (compression != kUncompressed && compression != kBitFields) return;
  if (reader.U32(10) + (width * bits + 31) / 32 * 4 * height > bytes.size()) FailTruncated();
}

// That nothing is cut off. The size is checked where libwebp has read it (DecodeWebp).
void CheckWebp(const Bytes& bytes) {
  const ByteReader reader(bytes, false);
  if (uint64_t{8} + reader.U32(4) > bytes.size()) FailTruncated();
  for (const char* type : {"VP8 ", "VP8L", "VP8X"}) {
    if (HasPrefix(bytes, 12, type, 4)) return;
  }
  Fail("corrupt: WebP without a picture");
}

/// The first directory of a TIFF file.
class TiffDirectory {
 public:
  explicit TiffDirectory(const Bytes& bytes) : reader_(bytes, bytes[0] == 'M') {
    at_ = reader_.U32(4);
    count_ = reader_.U16(at_);
    reader_.U32(at_ + 2 + 12 * uint64_t{count_});  // the next directory's place
    constexpr int kSizes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8};
    for (uint32_t i = 0; i < count_; ++i) {
      const uint64_t entry = Entry(i);
      const uint32_t type = reader_.U16(entry + 2);
      const uint64_t size = uint64_t{reader_.U32(entry + 4)} * (type <= 12 ? kSizes[type] : 0);
      if (size > 4 && reader_.U32(entry + 8) + size > bytes.size()) FailTruncated();
    }
  }

  bool Has(uint32_t tag) const {
    for (uint32_t i = 0; i < count_; ++i) {
      if (reader_.U16(Entry(i)) == tag) return true;
    }
    return false;
  }

  std::vector<uint32_t> Values(uint32_t tag) const {
    std::vector<uint32_t> values;
    for (uint32_t i = 0; i < count_; ++i) {
      const uint64_t entry = Entry(i);
      if (reader_.U16(entry) != tag) continue;
      constexpr uint32_t kShort = 3, kLong = 4;
      const uint32_t type = reader_.U16(entry + 2);
      if (type != kShort && type != kLong) break;
      const int size = type == kShort ? 2 : 4;
      const uint64_t count = reader_.U32(entry + 4);
      const uint64_t data = count * size <= 4 ? entry + 8 : reader_.U32(entry + 8);
      for (uint64_t k = 0; k < count; ++k) values.push_back(reader_.Get(data + k * size, size));
      break;
    }
    return values;
  }

 private:
  uint64_t Entry(uint32_t i) const { return at_ + 2 + 12 * uint64_t{i}; }

  ByteReader reader_;
  uint64_t at_;
  uint32_t count_;
};

// Decoders ask for the memory of a whole tile, however small the picture is. Writers use one size
// of tiles for pictures of any size: larger than the picture they may be, up to what does no harm.
void CheckTileSize(const TiffDirectory& directory, uint64_t image_pixels) {
  constexpr uint32_t kTileWidth = 322, kTileHeight = 323;
  constexpr uint64_t kHarmless = uint64_t{1} << 24, kMostImages = 4;
  // With one of the two, whatever its type, libtiff takes strips for tiles.
  if (!directory.Has(kTileWidth) && !directory.Has(kTileHeight)) return;
  const auto width = directory.Values(kTileWidth), height = directory.Values(kTileHeight);
  if (width.size() != 1 || height.size() != 1) Fail("corrupt: TIFF tiles without a size");
  const uint64_t pixels = uint64_t{width[0]} * height[0];
  if (pixels == 0 || pixels > std::max(kHarmless, kMostImages * image_pixels)) {
    Fail("corrupt: TIFF tiles of " + std::to_string(width[0]) + "x" + std::to_string(height[0]) +
         " pixels");
  }
}

void CheckTiff(const Bytes& bytes, uint64_t max_pixels) {
  constexpr uint32_t kWidth = 256, kHeight = 257;
  constexpr uint32_t kStrips = 273, kStripSizes = 279, kTiles = 324, kTileSizes = 325;
  const TiffDirectory directory(bytes);
  const auto width = directory.Values(kWidth), height = directory.Values(kHeight);
  if (width.size() != 1 || height.size() != 1) Fail("corrupt: TIFF without a size");
  CheckImageSize(width[0], height[0], max_pixels);
  CheckTileSize(directory, uint64_t{width[0]} * height[0]);
  bool has_data = false;
  for (const auto& [places_tag, sizes_tag] :
       {std::pair(kStrips, kStripSizes), std::pair(kTiles, kTileSizes)}) {
    const auto places = directory.Values(places_tag), sizes = directory.Values(sizes_tag);
    if (places.size() != sizes.size()) Fail("corrupt: TIFF without pixel data");
    for (size_t i = 0; i < places.size(); ++i) {
      if (uint64_t{places[i]} + sizes[i] > bytes.size()) FailTruncated();
      has_data = true;
    }
  }
  if (!has_data) Fail("corrupt: TIFF without pixel data");
}

// --- PNM ---------------------------------------------------------------------------------------

/// Header and samples of a PNM file, in reading order.
class PnmReader {
 public:
  PnmReader(const Bytes& bytes, uint64_t max_pixels) : bytes_(bytes), kind_(bytes[1] - '0') {
    width = Number();
    height = Number();
    max = bitmap() ? 1 : Number();
    CheckImageSize(width, height, max_pixels);
    if (max < 1 || max > 65535) Fail("corrupt: PNM maximum value " + std::to_string(max));
    if (raw()) ++at_;  // one white space
    if (at_ + LeastBytes() > bytes_.size()) FailTruncated();
  }

  int channels() const { return kind_ % 3 == 0 ? 3 : 1; }

  /// The next sample, at most max. Every row of a raw bitmap starts on a byte: x is its column.
  uint32_t Sample(uint64_t x) {
    uint32_t value;
    if (kind_ == 1) {
      SkipBlanks();
      value = bytes_[at_++] == '0' ? 1 : 0;  // 1 is black
    } else if (kind_ == 4) {
      value = ~bytes_[at_] >> (7 - x % 8) & 1;
      if (x % 8 == 7 || x + 1 == width) ++at_;
    } else if (!raw()) {
      value = Number();
    } else {
      value = bytes_[at_++];
      if (max > 255) value = value << 8 | bytes_[at_++];
    }
    return std::min(value, max);
  }

  uint32_t width = 0, height = 0, max = 0;

 private:
  bool raw() const { return kind_ >= 4; }
  bool bitmap() const { return kind_ % 3 == 1; }

  // Of all samples; those that are text need a digit each, and what keeps them apart.
  uint64_t LeastBytes() const {
    const uint64_t samples = uint64_t{width} * height * channels();
    if (kind_ == 1) return samples;
    if (kind_ == 4) return (uint64_t{width} + 7) / 8 * height;
    return raw() ? samples * (max > 255 ? 2 : 1) : 2 * samples - 1;
  }

  void SkipBlanks() {
    for (bool comment = false;; ++at_) {
      if (at_ >= bytes_.size()) FailTruncated();
      const uint8_t c = bytes_[at_];
      if (c == '#') comment = true;
      if (c == '\n') comment = false;
      if (!comment && c != ' ' && (c < '\t' || c > '\r')) return;
    }
  }

  uint32_t Number() {
    SkipBlanks();
    uint32_t value = 0;
    const uint64_t begin = at_;
    for (; at_ < bytes_.size() && bytes_[at_] >= '0' && bytes_[at_] <= '9'; ++at_) {
      value = std::min(value * 10 + (bytes_[at_] - '0'), 100000000u);
    }
    if (at_ == begin) Fail("corrupt: a number is missing in the PNM file");
    return value;
  }

  const Bytes& bytes_;
  int kind_;
  uint64_t at_ = 2;
};

}  // namespace

void CheckImageSize(uint64_t width, uint64_t height, uint64_t max_pixels) {
  const std::string size = std::to_string(width) + "x" + std::to_string(height) + " pixels";
  if (width == 0 || height == 0) Fail("corrupt: " + size);
  if (width > kMaxImageSide || height > kMaxImageSide) {
    Fail("too large: " + size + ", at most " + std::to_string(kMaxImageSide) +
         " on a side are supported");
  }
  if (width * height > max_pixels) {
    throw Error(ErrorCode::kTooLarge,
                "too large: " + size + ", more than the limit of " + std::to_string(max_pixels));
  }
}

ImageFormat CheckEncodedImage(std::vector<uint8_t>* bytes, uint64_t max_pixels) {
  const auto starts = [&](const char* prefix, size_t size) {
    return HasPrefix(*bytes, 0, prefix, size);
  };
  if (HasPrefix(*bytes, 0, kPngSignature, sizeof(kPngSignature))) {
    CheckPng(bytes, max_pixels);
    return ImageFormat::kPng;
  }
  if (starts("\xFF\xD8", 2)) {
    CheckJpeg(*bytes);
    return ImageFormat::kJpeg;
  }
  if (starts("RIFF", 4) && HasPrefix(*bytes, 8, "WEBP", 4)) {
    CheckWebp(*bytes);
    return ImageFormat::kWebp;
  }
  if (starts("II*\0", 4) || starts("MM\0*", 4)) {
    CheckTiff(*bytes, max_pixels);
    return ImageFormat::kTiff;
  }
  if (starts("BM", 2)) {
    CheckBmp(*bytes, max_pixels);
    return ImageFormat::kBmp;
  }
  if (bytes->size() >= 3 && (*bytes)[0] == 'P' && (*bytes)[1] >= '1' && (*bytes)[1] <= '6') {
    PnmReader header(*bytes, max_pixels);
    return ImageFormat::kPnm;
  }
  Fail("not a PNG, JPEG, BMP, PNM, TIFF or WebP image");
}

Image DecodePnm(const std::vector<uint8_t>& bytes) {
  PnmReader reader(bytes, std::numeric_limits<uint64_t>::max());
  Image image(static_cast<int>(reader.width), static_cast<int>(reader.height));
  for (int y = 0; y < image.height(); ++y) {
    uint8_t* out = image.row(y);
    for (int x = 0; x < image.width(); ++x) {
      const uint32_t r = reader.Sample(x);
      const uint32_t g = reader.channels() == 3 ? reader.Sample(x) : r;
      const uint32_t b = reader.channels() == 3 ? reader.Sample(x) : r;
      out[x] = Luminance(r, g, b, reader.max);
    }
  }
  return image;
}

}  // namespace topotag
