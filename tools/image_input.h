#ifndef TOPOTAG_TOOLS_IMAGE_INPUT_H_
#define TOPOTAG_TOOLS_IMAGE_INPUT_H_

#include <cstdint>
#include <string>

#include "topotag/image.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace topotag::tools {

/// The option --max-pixels of a command that reads images.
CLI::Option* AddMaxPixels(CLI::App* command, const char* group, std::string* value);
/// Its value; kDefaultMaxPixels where it is empty, which is how it begins. @throws UsageError
uint64_t ParseMaxPixels(const std::string& text);

/// @throws Error (kTooLarge) that names the option --max-pixels.
void CheckPixels(int width, int height, uint64_t max_pixels);

/// An input image; what the decoders print is dropped.
/// @throws Error as ReadImage, beginning with the path; CheckPixels' where it is too large.
Image ReadInput(const std::string& path, uint64_t max_pixels);

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_IMAGE_INPUT_H_
