#include "tools/output.h"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "tools/command.h"
#include "topotag/error.h"

namespace topotag::tools {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailFile(const std::string& path, const std::string& reason) {
  throw Error(ErrorCode::kFile, path + ": " + reason);
}

std::string AbsolutePath(const std::string& path) {
  std::error_code error;
  fs::path absolute = fs::absolute(path, error);
  if (!error) absolute = fs::weakly_canonical(absolute, error);
  return error ? path : absolute.string();
}

}  // namespace

OutputStream::OutputStream(const std::string& path) : path_(path) {
  if (path.empty() || path == "-") {
    path_ = "standard output";
    stream_ = stdout;
    return;
  }
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status) || fs::is_regular_file(status) || fs::is_directory(status)) {
    file_ = ForFile(path, [&] { return std::make_unique<OutputFile>(path); });
    return;
  }
  // Devices and pipes are written as they are: there is nothing to replace.
  stream_ = std::fopen(path.c_str(), "w");
  if (stream_ == nullptr) Fail(errno);
}

OutputStream::~OutputStream() {
  if (stream_ != nullptr && !is_stdout()) std::fclose(stream_);
}

void OutputStream::Fail(int error_number) {
  if (error_number == EPIPE) throw BrokenPipe();
  FailFile(path_, "cannot write: " + SystemMessage(error_number));
}

void OutputStream::Write(const std::string& text) {
  if (file_) {
    ForFile(path_, [&] { file_->Write(text.data(), text.size()); });
    return;
  }
  if (std::fwrite(text.data(), 1, text.size(), stream_) != text.size()) Fail(errno);
  if (is_stdout() && std::fflush(stream_) != 0) Fail(errno);
}

void OutputStream::Finish() {
  if (file_) ForFile(path_, [&] { file_->Commit(); });
  if (stream_ == nullptr || is_stdout()) return;
  std::FILE* stream = stream_;
  stream_ = nullptr;
  if (std::fclose(stream) != 0) Fail(errno);
}

void WriteOutput(const std::string& path, const std::string& text) {
  OutputStream stream(path);
  stream.Write(text);
  stream.Finish();
}

void CheckOutputs(const std::vector<NamedOutput>& outputs, const std::vector<std::string>& inputs) {
  std::error_code ignored;
  std::map<std::string, const char*> written;
  for (const auto& [option, path] : outputs) {
    const bool is_file = !fs::exists(path, ignored) || fs::is_regular_file(path, ignored);
    if (path.empty() || path == "-" || !is_file) continue;
    for (const std::string& input : inputs) {
      if (fs::equivalent(path, input, ignored)) {
        throw UsageError(std::string(option) + ": " + path + " is an input");
      }
    }
    const auto [other, is_new] = written.emplace(AbsolutePath(path), option);
    if (!is_new) {
      throw UsageError(std::string(option) + ": " + path + " is that of " + other->second +
                       ", too");
    }
  }
}

void MakeFolder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (std::error_code ignored; !fs::is_directory(folder, ignored)) {
    FailFile(folder, "folder cannot be created: " + (error ? error.message() : "is a file"));
  }
}

TakenFiles::TakenFiles(const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) Add(input);
}

bool TakenFiles::Has(const std::string& path) const {
  return paths_.count(AbsolutePath(path)) != 0;
}

void TakenFiles::Add(const std::string& path) { paths_.insert(AbsolutePath(path)); }

PictureFolder::PictureFolder(const std::string& folder, TakenFiles* taken)
    : folder_(folder), taken_(*taken) {
  MakeFolder(folder);
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    FailFile(folder, "folder cannot be written to: " + SystemMessage(errno));
  }
}

void PictureFolder::Write(const std::string& stem, const std::vector<Picture>& pictures) {
  std::vector<std::string> paths;
  for (int copy = 1; paths.size() != pictures.size(); ++copy) {
    const std::string name = copy == 1 ? stem : stem + "_" + std::to_string(copy);
    paths.clear();
    for (const Picture& picture : pictures) {
      const std::string path = (fs::path(folder_) / (name + picture.suffix + ".png")).string();
      if (taken_.Has(path)) break;
      paths.push_back(path);
    }
  }
  for (size_t i = 0; i < pictures.size(); ++i) {
    taken_.Add(paths[i]);
    std::vector<uchar> bytes;
    cv::imencode(".png", pictures[i].pixels, bytes);
    ForFile(paths[i], [&] { WriteWholeFile(paths[i], bytes.data(), bytes.size()); });
  }
}

}  // namespace topotag::tools
