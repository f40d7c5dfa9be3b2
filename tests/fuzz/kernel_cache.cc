// The file in which compiled kernels are kept: whatever it holds, a binary that was written whole
// under this very key, or none. The first byte says how much of a right file the others replace.

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "host/file.h"
#include "kernels/cache_file.h"
#include "tests/fuzz/input.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/target.h"

namespace topotag::fuzz {
namespace {

const char kKey[] = "topotag kernels\nplatform\ndevice\nversion\ndriver\n-cl-std=CL1.2\nsource\n";

enum Kind { kBytes, kBinary, kDamaged, kOtherKey, kKinds };

std::string Path() {
  static const std::string path =
      (std::filesystem::temp_directory_path() / ("fuzz_cache_" + std::to_string(getpid())))
          .string();
  return path;
}

// The bytes of a cache file.
std::string FileOf(const std::string& key, const std::string& binary) {
  opencl::WriteCacheFile(Path(), key, binary);
  const std::string bytes = ReadText(Path(), size_t{1} << 24);
  std::filesystem::remove(Path());
  return bytes;
}

std::string Read(const std::string& bytes) {
  static MemoryFile file;
  file.Set(bytes);
  return opencl::ReadCacheFile(file.path(), kKey);
}

void CheckBytes(const std::string& bytes) {
  const std::string binary = Read(bytes);
  if (!binary.empty()) Require(FileOf(kKey, binary) == bytes, "a file is read that none wrote");
}

// One byte of it is changed, or its end is cut off.
void CheckDamaged(Input* input) {
  const int at = input->Between(0, 65535);
  const char flip = static_cast<char>(input->Byte());
  std::string bytes = FileOf(kKey, input->Rest());
  const size_t place = static_cast<size_t>(at) % bytes.size();
  if (flip == 0) {
    bytes.resize(place);
  } else {
    bytes[place] = static_cast<char>(bytes[place] ^ flip);
  }
  Require(Read(bytes).empty(), "a damaged file is read");
}

}  // namespace

std::vector<std::string> Seeds() {
  const std::string binary =
      "\x7f"
      "ELF compiled";
  return {std::string(1, kBytes) + FileOf(kKey, binary), std::string(1, kBytes) + kKey,
          std::string(1, kBinary) + binary, std::string(1, kDamaged) + "\x01\x02\x03" + binary,
          std::string(1, kOtherKey) + binary};
}

}  // namespace topotag::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace topotag::fuzz;
  Input input(data, size);
  switch (input.Byte() % kKinds) {
    case kBytes:
      CheckBytes(input.Rest());
      break;
    case kBinary: {
      const std::string binary = input.Rest();
      Require(Read(FileOf(kKey, binary)) == binary, "a file is not read as it was written");
      break;
    }
    case kDamaged:
      CheckDamaged(&input);
      break;
    default:
      const std::string key = std::string(kKey) + "x";
      Require(Read(FileOf(key, input.Rest())).empty(), "the file of another key is read");
  }
  return 0;
}
