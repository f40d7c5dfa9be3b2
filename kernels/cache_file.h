#ifndef TOPOTAG_KERNELS_CACHE_FILE_H_
#define TOPOTAG_KERNELS_CACHE_FILE_H_

#include <string>

namespace topotag::opencl {

/// The name, without folder, of the cache file of this key.
std::string CacheFileName(const std::string& key);

/// The binary in a cache file, which is: key, hash of the binary, binary.
/// @param key  everything that the binary depends on: two with the same hash are not mixed up
/// @return empty where there is no such file, it cannot be read, is damaged or of another key
std::string ReadCacheFile(const std::string& path, const std::string& key);

/// Makes its folder too. @throws std::exception where it cannot be written
void WriteCacheFile(const std::string& path, const std::string& key, const std::string& binary);

}  // namespace topotag::opencl

#endif  // TOPOTAG_KERNELS_CACHE_FILE_H_
