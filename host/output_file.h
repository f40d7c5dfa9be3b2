#ifndef TOPOTAG_HOST_OUTPUT_FILE_H_
#define TOPOTAG_HOST_OUTPUT_FILE_H_

#include <string>

namespace topotag {

/// Writes a whole file: first to a temporary name in the same folder, then renamed, so that a
/// failure leaves neither a half-written file nor the temporary one, and an old file stays.
/// @throws Error (kFile) that names the path and the reason.
void WriteWholeFile(const std::string& path, const std::string& bytes);

}  // namespace topotag

#endif  // TOPOTAG_HOST_OUTPUT_FILE_H_
