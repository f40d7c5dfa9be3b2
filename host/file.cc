#include "host/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include "topotag/error.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailRead(const std::string& reason) { throw Error(ErrorCode::kFile, reason); }

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

// The path by which a file without a name is given one. No allocation, which could fail.
class LinkPath {
 public:
  explicit LinkPath(int descriptor) {
    std::snprintf(path_, sizeof(path_), "/proc/self/fd/%d", descriptor);
  }
  const char* get() const { return path_; }

 private:
  char path_[32];
};

template <typename Bytes>
Bytes ReadFile(const std::string& path, size_t max_size) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) FailRead(error ? error.message() : SystemMessage(ENOENT));
  if (fs::is_directory(status)) FailRead(SystemMessage(EISDIR));
  if (!fs::is_regular_file(status)) FailRead("not a regular file");
  const uintmax_t size = fs::file_size(path, error);
  if (error) FailRead(error.message());
  if (size > max_size) FailRead("the file is larger than " + std::to_string(max_size) + " bytes");
  errno = 0;
  const File file(std::fopen(path.c_str(), "rb"));
  if (file == nullptr) FailRead(SystemMessage(errno));
  Bytes bytes(size, 0);
  const size_t read = std::fread(bytes.data(), 1, bytes.size(), file.get());
  if (std::ferror(file.get()) != 0) FailRead(SystemMessage(errno));
  bytes.resize(read);
  return bytes;
}

}  // namespace

std::string SystemMessage(int error_number) {
  return std::generic_category().message(error_number);
}

std::string LowerExtension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c; };
  std::transform(extension.begin(), extension.end(), extension.begin(), lower);
  return extension;
}

std::vector<uint8_t> ReadBytes(const std::string& path, size_t max_size) {
  return ReadFile<std::vector<uint8_t>>(path, max_size);
}

std::string ReadText(const std::string& path, size_t max_size) {
  return ReadFile<std::string>(path, max_size);
}

OutputFile::OutputFile(const std::string& path) : path_(path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) Fail(EISDIR);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw Error(ErrorCode::kFile, "cannot write '" + path + "': not a regular file");
  }
  const fs::path target = fs::weakly_canonical(path, error);
  target_ = error ? path : target.string();
  if (fs::exists(status)) {
    // Renaming needs rights on the folder only: a file that is protected stays so.
    errno = 0;
    const File writable(std::fopen(target_.c_str(), "r+b"));
    if (writable == nullptr) Fail(errno);
  }
  CreateUnnamed();
  if (file_ == nullptr) CreateNamed();
  // What was not for everyone's eyes is not afterwards.
  if (fs::exists(status)) fchmod(fileno(file_), static_cast<mode_t>(status.permissions()));
}

OutputFile::~OutputFile() {
  if (file_ != nullptr) std::fclose(file_);
  if (!temporary_.empty()) std::remove(temporary_.c_str());
}

// Leaves file_ null where the file system, or a system without /proc, cannot do it.
void OutputFile::CreateUnnamed() {
#ifdef O_TMPFILE
  const fs::path parent = fs::path(target_).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  const int descriptor = open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
  if (descriptor < 0) return;
  if (access(LinkPath(descriptor).get(), F_OK) == 0) file_ = fdopen(descriptor, "wb");
  if (file_ == nullptr) close(descriptor);
#endif
}

void OutputFile::CreateNamed() {
  const auto create = [this](const char* temporary) {
    file_ = std::fopen(temporary, "wbx");
    return file_ != nullptr;
  };
  WithTemporaryName(create);
}

// Gives a complete file without a name its own; one that exists is replaced as a whole.
void OutputFile::Name() {
  const LinkPath link(fileno(file_));
  const auto add = [&link](const char* name) {
    return linkat(AT_FDCWD, link.get(), AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0;
  };
  if (add(target_.c_str())) return;
  if (errno != EEXIST) Fail(errno);
  WithTemporaryName(add);
}

// Exclusive creation: whoever else writes to this folder takes another name.
template <typename Create>
void OutputFile::WithTemporaryName(const Create& create) {
  constexpr int kAttempts = 10000;
  const fs::path folder = fs::path(target_).parent_path();
  for (int i = 0; i < kAttempts; ++i) {
    std::string name = (folder / (".topotag-" + std::to_string(i) + ".tmp")).string();
    if (create(name.c_str())) {
      temporary_ = std::move(name);
      return;
    }
    if (errno != EEXIST) break;
  }
  Fail(errno);
}

void OutputFile::Write(const void* bytes, size_t size) {
  errno = 0;
  if (std::fwrite(bytes, 1, size, file_) != size) Fail(errno);
}

void OutputFile::Commit() {
  errno = 0;
  if (std::fflush(file_) != 0) Fail(errno);
  // Some file systems find out at a close that there is no space: before the file has its name.
  if (close(dup(fileno(file_))) != 0) Fail(errno);
  if (temporary_.empty()) Name();
  std::FILE* file = std::exchange(file_, nullptr);
  if (std::fclose(file) != 0) Fail(errno);
  if (temporary_.empty()) return;
  std::error_code error;
  fs::rename(temporary_, target_, error);
  if (error) Fail(error.value());
  temporary_.clear();
}

void OutputFile::Fail(int error_number) const {
  throw Error(ErrorCode::kFile, "cannot write '" + path_ + "': " + SystemMessage(error_number));
}

void WriteWholeFile(const std::string& path, const void* bytes, size_t size) {
  OutputFile file(path);
  file.Write(bytes, size);
  file.Commit();
}

void WriteWholeFile(const std::string& path, const std::string& text) {
  WriteWholeFile(path, text.data(), text.size());
}

}  // namespace topotag
