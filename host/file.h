#ifndef TOPOTAG_HOST_FILE_H_
#define TOPOTAG_HOST_FILE_H_

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace topotag {

/// "No such file or directory" for ENOENT.
std::string SystemMessage(int error_number);

/// The extension with its dot, in lower case: ".png" of "a/B.PNG"; "" where there is none.
std::string LowerExtension(const std::string& path);

/// The bytes of a regular file; of anything else, such as a pipe, reading may never end.
/// @throws Error (kFile) with the reason only: cannot be opened or read, not a regular file,
///         larger than max_size bytes.
std::vector<uint8_t> ReadBytes(const std::string& path, size_t max_size);
std::string ReadText(const std::string& path, size_t max_size);

/// A file that appears under its name only when it is complete. Until then it has none, so that
/// nothing is left behind however the process ends; where the file system knows no such files, it
/// has a temporary one in the same folder. A failure leaves neither of the two, and an old file
/// stays. A file that is replaced hands on its permissions; where the path is a symbolic link to a
/// file, that file is replaced.
/// Every error is an Error (kFile) "cannot write 'PATH': REASON".
class OutputFile {
 public:
  /// @throws Error also where something stands in the way that is no file to be replaced: a
  ///         folder, a device, a pipe, a file that may not be written.
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void Write(const void* bytes, size_t size);
  /// Gives the file its name; nothing may be written after it.
  void Commit();

 private:
  void CreateUnnamed();
  void CreateNamed();
  void Name();
  template <typename Create>
  void WithTemporaryName(const Create& create);
  [[noreturn]] void Fail(int error_number) const;

  std::string path_;       ///< as the caller wrote it, for messages
  std::string target_;     ///< without symbolic links
  std::string temporary_;  ///< empty while the file has no name
  std::FILE* file_ = nullptr;
};

/// @throws Error (kFile) that names the path and the reason.
void WriteWholeFile(const std::string& path, const void* bytes, size_t size);
void WriteWholeFile(const std::string& path, const std::string& text);

}  // namespace topotag

#endif  // TOPOTAG_HOST_FILE_H_
