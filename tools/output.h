#ifndef TOPOTAG_TOOLS_OUTPUT_H_
#define TOPOTAG_TOOLS_OUTPUT_H_

#include <cstdio>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <vector>

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
  /// Leaves nothing behind where Finish was not reached.
  ~OutputStream();
  OutputStream(const OutputStream&) = delete;
  OutputStream& operator=(const OutputStream&) = delete;

  /// Standard output is flushed after each call.
  /// @throws Error (kFile) that names the path; BrokenPipe.
  void Write(const std::string& text);
  /// Gives the file its name. @throws Error (kFile).
  void Finish();
  bool is_stdout() const { return file_ == stdout; }

 private:
  void Fail(int error_number);

  std::string path_;    ///< as the user wrote it, for messages
  std::string target_;  ///< without symbolic links; empty where nothing is to be renamed
  std::string temporary_;
  std::FILE* file_ = nullptr;
};

/// Writes a whole file under a temporary name and renames it.
/// @throws Error (kFile) that names the path.
void WriteWholeFile(const std::string& path, const std::string& bytes);

/// Creates a folder and its parents where they do not exist.
/// @throws Error (kFile) that names the folder.
void MakeFolder(const std::string& folder);

/// A folder of PNG pictures that never overwrites an input or a picture of the same run.
class PictureFolder {
 public:
  /// Creates the folder and proves that it can be written to.
  /// @param inputs  files that must stay as they are.
  /// @throws Error (kFile) that names the folder.
  PictureFolder(const std::string& folder, const std::vector<std::string>& inputs);

  /// Writes STEM + each suffix + ".png"; STEM gets _2, _3, .. where a name is taken.
  /// @throws Error (kFile) that names the file.
  struct Picture {
    std::string suffix;
    cv::Mat pixels;
  };
  void Write(const std::string& stem, const std::vector<Picture>& pictures);

 private:
  std::string folder_;
  std::set<std::string> taken_;  ///< absolute paths
};

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_OUTPUT_H_
