#include "host/output_file.h"

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "topotag/error.h"

namespace topotag {
namespace {

[[noreturn]] void Fail(const std::string& path, const std::string& reason) {
  throw Error(ErrorCode::kFile, "cannot write '" + path + "': " + reason);
}

std::string Reason(int error) { return std::generic_category().message(error); }

}  // namespace

void WriteWholeFile(const std::string& path, const std::string& bytes) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::is_directory(path, error)) Fail(path, Reason(EISDIR));
  // Exclusive creation: another process or thread that writes here takes the next name.
  fs::path temporary;
  std::FILE* file = nullptr;
  errno = EEXIST;
  for (int i = 0; file == nullptr && errno == EEXIST; ++i) {
    temporary = fs::path(path).parent_path() / (".topotag-" + std::to_string(i) + ".tmp");
    file = std::fopen(temporary.c_str(), "wbx");
  }
  if (file == nullptr) Fail(path, Reason(errno));
  int failure = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size()) failure = errno;
  if (std::fclose(file) != 0 && failure == 0) failure = errno;
  if (failure == 0) {
    fs::rename(temporary, path, error);
    if (!error) return;
    failure = error.value();
  }
  fs::remove(temporary, error);
  Fail(path, Reason(failure));
}

}  // namespace topotag
