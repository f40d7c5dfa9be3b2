#ifndef TOPOTAG_TOOLS_OUTPUT_H_
#define TOPOTAG_TOOLS_OUTPUT_H_

#include <cstdio>
#include <memory>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/file.h"

namespace topotag::tools {

/// The reader of standard output has gone: the command ends without a complaint.
class BrokenPipe {};

/// Where results go: standard output, line by line, or a file that appears under its name only
/// when it is complete.
class OutputStream {
 public:
  /// Standard output for "" and "-".
  /// @throws Error (kFile) that names the path.
  explicit OutputStream(const std::string& path);
  /// Leaves nothing behind where Finish was not reached; a device keeps what it was given.
  ~OutputStream();
  OutputStream(const OutputStream&) = delete;
  OutputStream& operator=(const OutputStream&) = delete;

  /// Standard output is flushed after each call.
  /// @throws Error (kFile) that names the path; BrokenPipe.
  void Write(const std::string& text);
  /// Gives the file its name. @throws Error (kFile).
  void Finish();
  bool is_stdout() const { return stream_ == stdout; }

 private:
  [[noreturn]] void Fail(int error_number);

  std::string path_;                  ///< as the user wrote it, for messages
  std::unique_ptr<OutputFile> file_;  ///< a regular file; else null, and there is a stream_
  std::FILE* stream_ = nullptr;       ///< standard output, a device or a pipe
};

/// Writes all of an OutputStream.
void WriteOutput(const std::string& path, const std::string& text);

/// An option and the file that it names; none for "" and "-".
using NamedOutput = std::pair<const char*, std::string>;

/// Nothing that is read is written over, and nothing is written twice; devices and pipes may be.
/// @throws UsageError that names the option and the file.
void CheckOutputs(const std::vector<NamedOutput>& outputs, const std::vector<std::string>& inputs);

/// Creates a folder and its parents where they do not exist.
/// @throws Error (kFile) that names the folder.
void MakeFolder(const std::string& folder);

/// Files that pictures may not be written over: inputs, and pictures of the same run.
class TakenFiles {
 public:
  explicit TakenFiles(const std::vector<std::string>& inputs);
  bool Has(const std::string& path) const;
  void Add(const std::string& path);

 private:
  std::set<std::string> paths_;  ///< absolute
};

/// A folder of PNG pictures that overwrites none of the files that are taken, and takes its own.
class PictureFolder {
 public:
  /// Creates the folder and proves that it can be written to. Refers to `taken`.
  /// @throws Error (kFile) that names the folder.
  PictureFolder(const std::string& folder, TakenFiles* taken);

  /// Writes STEM + each suffix + ".png"; STEM gets _2, _3, .. where a name is taken.
  /// @throws Error (kFile) that names the file.
  struct Picture {
    std::string suffix;
    cv::Mat pixels;
  };
  void Write(const std::string& stem, const std::vector<Picture>& pictures);

 private:
  std::string folder_;
  TakenFiles& taken_;
};

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_OUTPUT_H_
