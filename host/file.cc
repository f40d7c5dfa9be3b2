#include "host/file.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <memory>
#include <system_error>

#include "topotag/error.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailRead(const std::string& reason) { throw Error(ErrorCode::kFile, reason); }

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

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
  Create();
}

OutputFile::~OutputFile() {
  if (file_ != nullptr) std::fclose(file_);
  if (!temporary_.empty()) std::remove(temporary_.c_str());
}

void OutputFile::Create() {
  constexpr int kAttempts = 10000;
  const fs::path folder = fs::path(target_).parent_path();
  // Exclusive creation: whoever else writes to this folder takes another name.
  errno = EEXIST;
  for (int i = 0; file_ == nullptr && errno == EEXIST && i < kAttempts; ++i) {
    temporary_ = (folder / (".topotag-" + std::to_string(i) + ".tmp")).string();
    file_ = std::fopen(temporary_.c_str(), "wbx");
  }
  if (file_ != nullptr) return;
  temporary_.clear();
  Fail(errno);
}

void OutputFile::Write(const void* bytes, size_t size) {
  errno = 0;
  if (std::fwrite(bytes, 1, size, file_) != size) Fail(errno);
}

void OutputFile::Commit() {
  std::FILE* file = file_;
  file_ = nullptr;
  errno = 0;
  if (std::fclose(file) != 0) Fail(errno);
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
