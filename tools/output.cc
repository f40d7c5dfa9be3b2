#include "tools/output.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "topotag/error.h"

namespace topotag::tools {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailFile(const std::string& path, const std::string& reason) {
  throw Error(ErrorCode::kFile, path + ": " + reason);
}

/// Opens a new file next to `target`, so that a rename stays within the file system.
std::FILE* OpenTemporary(const std::string& target, std::string* temporary) {
  const std::string stem = target + ".tmp-" + std::to_string(getpid());
  for (int attempt = 0; attempt < 100; ++attempt) {
    *temporary = stem + "-" + std::to_string(attempt);
    const int descriptor = open(temporary->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) return fdopen(descriptor, "w");
    if (errno != EEXIST) break;
  }
  temporary->clear();
  return nullptr;
}

std::string AbsolutePath(const std::string& path) {
  std::error_code error;
  const fs::path absolute = fs::weakly_canonical(path, error);
  return error ? path : absolute.string();
}

}  // namespace

OutputStream::OutputStream(const std::string& path) : path_(path) {
  if (path.empty() || path == "-") {
    path_ = "standard output";
    file_ = stdout;
    return;
  }
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) FailFile(path, "cannot be written: is a folder");
  if (fs::exists(status) && access(path.c_str(), W_OK) != 0) {
    FailFile(path, std::string("cannot be written: ") + std::strerror(errno));
  }
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    // Devices and pipes are written as they are: a rename would replace them.
    file_ = std::fopen(path.c_str(), "w");
  } else {
    target_ = AbsolutePath(path);
    file_ = OpenTemporary(target_, &temporary_);
  }
  if (file_ == nullptr) FailFile(path, std::string("cannot be written: ") + std::strerror(errno));
}

OutputStream::~OutputStream() {
  if (file_ != nullptr && file_ != stdout) std::fclose(file_);
  if (!temporary_.empty()) unlink(temporary_.c_str());
}

void OutputStream::Fail(int error_number) {
  if (error_number == EPIPE) throw BrokenPipe();
  FailFile(path_, std::string("cannot be written: ") + std::strerror(error_number));
}

void OutputStream::Write(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) Fail(errno);
  if (file_ == stdout && std::fflush(file_) != 0) Fail(errno);
}

void OutputStream::Finish() {
  if (file_ == stdout) return;
  std::FILE* file = file_;
  file_ = nullptr;
  if (std::fclose(file) != 0) Fail(errno);
  if (temporary_.empty()) return;
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) Fail(errno);
  temporary_.clear();
}

void WriteWholeFile(const std::string& path, const std::string& bytes) {
  OutputStream stream(path);
  stream.Write(bytes);
  stream.Finish();
}

void MakeFolder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder)) {
    FailFile(folder, "folder cannot be created: " + (error ? error.message() : "is a file"));
  }
}

PictureFolder::PictureFolder(const std::string& folder, const std::vector<std::string>& inputs)
    : folder_(folder) {
  MakeFolder(folder);
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    FailFile(folder, std::string("folder cannot be written to: ") + std::strerror(errno));
  }
  for (const std::string& input : inputs) taken_.insert(AbsolutePath(input));
}

void PictureFolder::Write(const std::string& stem, const std::vector<Picture>& pictures) {
  std::vector<std::string> paths;
  for (int copy = 1; paths.size() != pictures.size(); ++copy) {
    const std::string name = copy == 1 ? stem : stem + "_" + std::to_string(copy);
    paths.clear();
    for (const Picture& picture : pictures) {
      const std::string path = (fs::path(folder_) / (name + picture.suffix + ".png")).string();
      if (taken_.count(AbsolutePath(path)) != 0) break;
      paths.push_back(path);
    }
  }
  for (size_t i = 0; i < pictures.size(); ++i) {
    taken_.insert(AbsolutePath(paths[i]));
    std::vector<uchar> bytes;
    cv::imencode(".png", pictures[i].pixels, bytes);
    WriteWholeFile(paths[i], std::string(bytes.begin(), bytes.end()));
  }
}

}  // namespace topotag::tools
