#ifndef TOPOTAG_ERROR_H_
#define TOPOTAG_ERROR_H_

#include <stdexcept>
#include <string>

namespace topotag {

enum class ErrorCode {
  kInvalidArgument,  ///< a value outside its documented range
  kFile,             ///< a file that cannot be read or written
  kParse,            ///< a file whose content is malformed
  kUnavailable,      ///< a backend or device that this build or machine does not have
  kDevice,           ///< a failure reported by an OpenCL device
  kTooLarge,         ///< an image of more pixels than the caller allows
};

/// The only exception type that the library throws on purpose. what() is one line that names
/// the value, file or option and the reason. Where memory runs out, std::bad_alloc comes through.
/// Control characters of a name or a file that is quoted have become blanks.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message);
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace topotag

#endif  // TOPOTAG_ERROR_H_
