#ifndef TOPOTAG_TOOLS_VIDEO_END_H_
#define TOPOTAG_TOOLS_VIDEO_END_H_

#include <cstdint>
#include <string>

namespace topotag::tools {

/// Bytes that a video file lacks by what its container says of its own size: AVI, MP4 and MOV,
/// Matroska and WebM. 0 where nothing is missing, the container does not say, or is another one.
/// Readers of videos take a file that was cut off for one that ends early.
uint64_t MissingBytes(const std::string& path);

/// Whether the container holds the number of its frames: AVI, MP4 and MOV, unless in fragments. Of
/// others readers only
/// know length times rate, which is no count where the rate varies.
bool CountsFrames(const std::string& path);

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_VIDEO_END_H_
