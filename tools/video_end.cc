#include "tools/video_end.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace topotag::tools {
namespace {

/// Reads numbers anywhere in a file; 0 beyond its end.
class Bytes {
 public:
  explicit Bytes(const std::string& path) : file_(path, std::ios::binary) {
    std::error_code error;
    const uintmax_t size = std::filesystem::file_size(path, error);
    size_ = error ? 0 : size;
  }

  uint64_t size() const { return size_; }
  bool Has(uint64_t at, const char* text) {
    char bytes[4] = {};
    Read(at, bytes, sizeof bytes);
    return std::memcmp(bytes, text, sizeof bytes) == 0;
  }
  uint64_t BigEndian(uint64_t at, int count) {
    unsigned char bytes[8] = {};
    Read(at, reinterpret_cast<char*>(bytes), count);
    uint64_t value = 0;
    for (int i = 0; i < count; ++i) value = value << 8 | bytes[i];
    return value;
  }
  uint64_t LittleEndian32(uint64_t at) {
    return __builtin_bswap32(static_cast<uint32_t>(BigEndian(at, 4)));
  }

 private:
  void Read(uint64_t at, char* bytes, int count) {
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(at));
    file_.read(bytes, count);
  }

  std::ifstream file_;
  uint64_t size_ = 0;
};

// Of a part that begins within the file.
uint64_t Missing(const Bytes& bytes, uint64_t begin, uint64_t length) {
  const uint64_t left = bytes.size() - begin;
  return length > left ? length - left : 0;
}

// One or more RIFF chunks. Who writes to a pipe cannot state their size.
uint64_t MissingOfAvi(Bytes* bytes) {
  for (uint64_t at = 0; at + 8 <= bytes->size() && bytes->Has(at, "RIFF");) {
    const uint64_t length = bytes->LittleEndian32(at + 4);
    if (length == 0 || length == 0xffffffff) return 0;
    const uint64_t missing = Missing(*bytes, at + 8, length);
    if (missing > 0) return missing;
    at += 8 + length + length % 2;
  }
  return 0;
}

// Calls use(begin, length) for each box. They follow each other; one of length 0 reaches to the
// end, whatever that is.
template <typename Use>
void ForEachBox(Bytes* bytes, Use use) {
  for (uint64_t at = 0; at + 8 <= bytes->size();) {
    uint64_t length = bytes->BigEndian(at, 4);
    if (length == 1) length = bytes->BigEndian(at + 8, 8);
    if (length < 8) return;
    use(at, length);
    if (length > bytes->size() - at) return;
    at += length;
  }
}

uint64_t MissingOfMp4(Bytes* bytes) {
  uint64_t missing = 0;
  ForEachBox(bytes, [&](uint64_t at, uint64_t length) { missing = Missing(*bytes, at, length); });
  return missing;
}

// The length of an element's identifier or size: leading zeros of its first byte.
int VariableLength(uint64_t first) {
  int length = 1;
  for (uint64_t bit = 0x80; bit != 0 && (first & bit) == 0; bit >>= 1) ++length;
  return length;
}

// A header, and a segment with everything else. A size of ones only is not known.
uint64_t MissingOfMatroska(Bytes* bytes) {
  for (uint64_t at = 0; at + 2 <= bytes->size();) {
    const int name_length = VariableLength(bytes->BigEndian(at, 1));
    const uint64_t size_at = at + static_cast<uint64_t>(name_length);
    const int size_length = VariableLength(bytes->BigEndian(size_at, 1));
    if (name_length > 4 || size_length > 8) return 0;
    const uint64_t ones = (uint64_t{1} << 7 * size_length) - 1;
    const uint64_t length = bytes->BigEndian(size_at, size_length) & ones;
    if (length == ones) return 0;
    const uint64_t begin = size_at + static_cast<uint64_t>(size_length);
    if (begin > bytes->size()) return 0;
    const uint64_t missing = Missing(*bytes, begin, length);
    if (missing > 0) return missing;
    at = begin + length;
  }
  return 0;
}

}  // namespace

uint64_t MissingBytes(const std::string& path) {
  Bytes bytes(path);
  if (bytes.Has(0, "RIFF")) return MissingOfAvi(&bytes);
  if (bytes.Has(4, "ftyp")) return MissingOfMp4(&bytes);
  if (bytes.Has(0, "\x1A\x45\xDF\xA3")) return MissingOfMatroska(&bytes);
  return 0;
}

bool CountsFrames(const std::string& path) {
  Bytes bytes(path);
  if (!bytes.Has(4, "ftyp")) return bytes.Has(0, "RIFF");
  bool fragments = false;
  ForEachBox(&bytes, [&](uint64_t at, uint64_t) { fragments |= bytes.Has(at + 4, "moof"); });
  return !fragments;
}

}  // namespace topotag::tools
