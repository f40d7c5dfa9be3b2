#ifndef TOPOTAG_TESTS_FUZZ_MEMORY_FILE_H_
#define TOPOTAG_TESTS_FUZZ_MEMORY_FILE_H_

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <string>
#include <system_error>

namespace topotag::fuzz {

/// A file with a path that never reaches a disk.
class MemoryFile {
 public:
  MemoryFile() : file_(memfd_create("topotag_fuzz", MFD_CLOEXEC)) {
    if (file_ < 0) Fail();
    path_ = "/proc/self/fd/" + std::to_string(file_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(file_); }

  const std::string& path() const { return path_; }

  void Set(const void* bytes, size_t size) {
    if (ftruncate(file_, 0) != 0) Fail();
    if (pwrite(file_, bytes, size, 0) != static_cast<ssize_t>(size)) Fail();
  }
  void Set(const std::string& text) { Set(text.data(), text.size()); }

 private:
  [[noreturn]] static void Fail() { throw std::system_error(errno, std::generic_category()); }

  int file_;
  std::string path_;
};

}  // namespace topotag::fuzz

#endif  // TOPOTAG_TESTS_FUZZ_MEMORY_FILE_H_
