#include "kernels/cache_file.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>

#include "host/file.h"

namespace topotag::opencl {
namespace {

constexpr size_t kMaxBinary = size_t{1} << 28;

// FNV-1a.
uint64_t Hash(const void* bytes, size_t size) {
  uint64_t hash = 0xcbf29ce484222325;
  for (size_t i = 0; i < size; ++i) {
    hash = (hash ^ static_cast<const uint8_t*>(bytes)[i]) * 0x100000001b3;
  }
  return hash;
}

}  // namespace

std::string CacheFileName(const std::string& key) {
  char name[32];
  std::snprintf(name, sizeof(name), "%016llx.bin",
                static_cast<unsigned long long>(Hash(key.data(), key.size())));
  return name;
}

std::string ReadCacheFile(const std::string& path, const std::string& key) {
  std::string file;
  try {
    file = ReadText(path, kMaxBinary);
  } catch (const std::exception&) {
    return {};
  }
  uint64_t hash = 0;
  const size_t begin = key.size() + sizeof(hash);
  if (file.size() <= begin || file.compare(0, key.size(), key) != 0) return {};
  std::memcpy(&hash, file.data() + key.size(), sizeof(hash));
  if (hash != Hash(file.data() + begin, file.size() - begin)) return {};
  return file.substr(begin);
}

void WriteCacheFile(const std::string& path, const std::string& key, const std::string& binary) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  const uint64_t hash = Hash(binary.data(), binary.size());
  OutputFile file(path);
  file.Write(key.data(), key.size());
  file.Write(&hash, sizeof(hash));
  file.Write(binary.data(), binary.size());
  file.Commit();
}

}  // namespace topotag::opencl
