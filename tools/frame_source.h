#ifndef TOPOTAG_TOOLS_FRAME_SOURCE_H_
#define TOPOTAG_TOOLS_FRAME_SOURCE_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "topotag/camera.h"
#include "topotag/image.h"

namespace topotag::tools {

/// One frame of an input.
struct Frame {
  std::string image;         ///< path of the image or video, or "camera:N"
  int64_t index = 0;         ///< within a video or camera; 0 for an image
  bool is_sequence = false;  ///< of a video or camera
  std::string stem;          ///< for the names of pictures; a video's ends with the frame's number
  ImageView pixels;          ///< valid until the next frame is read
  size_t input = 0;          ///< which one of the inputs, a folder being one
};

/// The frames of images, folders of images, video files and cameras, in order.
class FrameSource {
 public:
  /// Frames of more than `max_pixels` are errors.
  /// @throws UsageError on a malformed "camera:N". Everything else shows up in Next.
  explicit FrameSource(const std::vector<std::string>& inputs, uint64_t max_pixels);

  /// Reads the next frame. After an Error the next call goes on with the next input.
  /// @return false at the end of all inputs.
  /// @throws Error (kFile) that names the input and the reason.
  bool Next(Frame* frame);

  /// Whether the calibration is for frames like the last one; a video or camera is left where it is
  /// not, all of whose frames are of one size.
  /// @throws Error (kFile) that names the input and both sizes.
  void CheckSize(const Frame& frame, const Camera& camera, const std::string& camera_file);
  /// Frames of all inputs by the headers of the videos; 0 where a camera makes it endless.
  int64_t CountFrames() const;
  /// All inputs that are files.
  std::vector<std::string> Files() const;
  /// Whether the current input is a camera: it has no end of its own.
  bool at_camera() const;

 private:
  enum class Kind { kImage, kVideo, kCamera, kUnreadable };
  struct Input {
    Kind kind;
    std::string path;
    std::string reason;   ///< kUnreadable
    int camera = 0;       ///< kCamera
    size_t argument = 0;  ///< which one of the inputs, a folder being one
  };

  void Add(const std::string& path);
  void LeaveSequence();
  bool NextOfVideo(const Input& input, Frame* frame);
  /// Why a video's last frame may not be its end; empty where it is.
  std::string EarlyEnd(const std::string& path) const;

  uint64_t max_pixels_;
  std::vector<Input> inputs_;
  size_t next_ = 0;  ///< index of the input that is read next
  cv::VideoCapture video_;
  int64_t video_frame_ = 0;
  Image image_;
  cv::Mat decoded_;
  cv::Mat gray_;
};

/// Discards what image and video libraries print on stderr while it lives.
class QuietStderr {
 public:
  QuietStderr();
  ~QuietStderr();
  QuietStderr(const QuietStderr&) = delete;
  QuietStderr& operator=(const QuietStderr&) = delete;

 private:
  int saved_ = -1;
};

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_FRAME_SOURCE_H_
