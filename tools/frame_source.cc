#include "tools/frame_source.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <set>

#include "host/check.h"
#include "host/file.h"
#include "tools/command.h"
#include "tools/image_input.h"
#include "tools/video_end.h"
#include "topotag/error.h"
#include "topotag/image_file.h"

namespace topotag::tools {
namespace {

namespace fs = std::filesystem;

constexpr char kCameraPrefix[] = "camera:";

bool IsVideo(const std::string& path) {
  static const std::set<std::string> kVideo{
      ".3gp", ".asf", ".avi",  ".flv", ".gif", ".h264", ".m2ts", ".m4v", ".mjpeg", ".mjpg", ".mkv",
      ".mov", ".mp4", ".mpeg", ".mpg", ".mts", ".ogv",  ".ts",   ".vob", ".webm",  ".wmv",  ".y4m"};
  return kVideo.count(LowerExtension(path)) != 0;
}

/// Frames by the header; 0 = not stated.
int64_t StatedFrames(const cv::VideoCapture& video) {
  const double count = video.get(cv::CAP_PROP_FRAME_COUNT);
  return count >= 1 && count < 1e12 ? static_cast<int64_t>(count) : 0;
}

bool Open(cv::VideoCapture* video, const std::string& path) {
  // A path with a % is taken for a pattern of image files by one of OpenCV's readers.
  return video->open(path, cv::CAP_FFMPEG) || video->open(path, cv::CAP_OPENCV_MJPEG) ||
         video->open(path, cv::CAP_GSTREAMER);
}

void ToGray(const cv::Mat& decoded, cv::Mat* gray) {
  cv::Mat bytes = decoded;
  if (decoded.depth() == CV_16U) decoded.convertTo(bytes, CV_8U, 1.0 / 257);
  switch (bytes.channels()) {
    case 1:
      *gray = bytes;
      break;
    case 4:
      cv::cvtColor(bytes, *gray, cv::COLOR_BGRA2GRAY);
      break;
    default:
      cv::cvtColor(bytes, *gray, cv::COLOR_BGR2GRAY);
  }
}

}  // namespace

FrameSource::FrameSource(const std::vector<std::string>& inputs, uint64_t max_pixels)
    : max_pixels_(max_pixels) {
  size_t argument = 0;
  for (const std::string& input : inputs) {
    const size_t first = inputs_.size();
    if (input.compare(0, sizeof kCameraPrefix - 1, kCameraPrefix) == 0) {
      const uint64_t index = ParseUnsigned(input, input.substr(sizeof kCameraPrefix - 1));
      if (index > 1000) throw UsageError(input + ": a camera's index is at most 1000");
      inputs_.push_back({Kind::kCamera, input, "", static_cast<int>(index)});
    } else {
      Add(input);
    }
    for (size_t i = first; i < inputs_.size(); ++i) inputs_[i].argument = argument;
    ++argument;
  }
}

void FrameSource::Add(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    const std::string reason = error ? error.message() : "no such file or folder";
    inputs_.push_back({Kind::kUnreadable, path, reason});
  } else if (IsVideo(path) && !fs::is_directory(status) && !fs::is_regular_file(status)) {
    inputs_.push_back({Kind::kUnreadable, path, "not a regular file"});
  } else if (!fs::is_directory(status)) {
    inputs_.push_back({IsVideo(path) ? Kind::kVideo : Kind::kImage, path, ""});
  } else {
    try {
      for (const std::string& image : ListImages(path)) {
        inputs_.push_back({Kind::kImage, image, ""});
      }
    } catch (const std::exception& listing) {
      inputs_.push_back({Kind::kUnreadable, path, listing.what()});
    }
  }
}

bool FrameSource::Next(Frame* frame) {
  while (next_ < inputs_.size()) {
    const Input& input = inputs_[next_];
    switch (input.kind) {
      case Kind::kUnreadable:
        ++next_;
        throw Error(ErrorCode::kFile, Named(input.path, input.reason));
      case Kind::kImage: {
        ++next_;
        image_ = ReadInput(input.path, max_pixels_);
        *frame = {input.path,    0, false, fs::path(input.path).stem().string(), image_.view(),
                  input.argument};
        return true;
      }
      default:
        if (NextOfVideo(input, frame)) return true;
        ++next_;
    }
  }
  return false;
}

std::string FrameSource::EarlyEnd(const std::string& path) const {
  const int64_t stated = CountsFrames(path) ? StatedFrames(video_) : 0;
  std::string end = " after " + std::to_string(video_frame_);
  if (stated > video_frame_) end += " of " + std::to_string(stated);
  end += " frames";
  const uint64_t missing = MissingBytes(path);
  if (missing > 0) return "is cut off" + end + ": " + std::to_string(missing) + " bytes missing";
  // A few that cannot be decoded are left out by readers; a tenth is more than that.
  return video_frame_ + 1 < stated && 10 * video_frame_ < 9 * stated ? "ends" + end : "";
}

bool FrameSource::NextOfVideo(const Input& input, Frame* frame) {
  const bool is_camera = input.kind == Kind::kCamera;
  const auto fail = [&](const std::string& reason) {
    LeaveSequence();
    throw Error(ErrorCode::kFile, input.path + ": " + reason);
  };
  const QuietStderr quiet;
  if (!video_.isOpened()) {
    const bool opened = is_camera ? video_.open(input.camera) : Open(&video_, input.path);
    if (!opened) fail(is_camera ? "camera cannot be opened" : "is not a readable video");
    try {
      CheckPixels(static_cast<int>(video_.get(cv::CAP_PROP_FRAME_WIDTH)),
                  static_cast<int>(video_.get(cv::CAP_PROP_FRAME_HEIGHT)), max_pixels_);
    } catch (const Error& error) {
      fail(error.what());
    }
    video_frame_ = 0;
  }
  if (!video_.read(decoded_) || decoded_.empty()) {
    if (video_frame_ == 0) fail("no frame can be read");
    if (!is_camera) {
      const std::string reason = EarlyEnd(input.path);
      if (!reason.empty()) fail(reason);
    }
    video_.release();
    return false;
  }
  ToGray(decoded_, &gray_);
  const std::string stem =
      is_camera ? "camera" + std::to_string(input.camera) : fs::path(input.path).stem().string();
  char number[32];
  std::snprintf(number, sizeof number, "_%06lld", static_cast<long long>(video_frame_));
  *frame = {input.path,
            video_frame_++,
            true,
            stem + number,
            ImageView{gray_.data, gray_.cols, gray_.rows, static_cast<ptrdiff_t>(gray_.step)},
            input.argument};
  return true;
}

void FrameSource::CheckSize(const Frame& frame, const Camera& camera,
                            const std::string& camera_file) {
  const int width = frame.pixels.width, height = frame.pixels.height;
  if (camera.width == 0 || (width == camera.width && height == camera.height)) return;
  if (frame.is_sequence) LeaveSequence();
  throw Error(ErrorCode::kFile, frame.image + ": the image is " + Text(width, height) +
                                    ", the camera file " + camera_file + " is for " +
                                    Text(camera.width, camera.height));
}

void FrameSource::LeaveSequence() {
  video_.release();
  ++next_;
}

int64_t FrameSource::CountFrames() const {
  const QuietStderr quiet;
  int64_t total = 0;
  for (const Input& input : inputs_) {
    if (input.kind == Kind::kCamera) return 0;
    if (input.kind == Kind::kImage) ++total;
    if (input.kind == Kind::kVideo) {
      cv::VideoCapture video;
      if (Open(&video, input.path)) total += StatedFrames(video);
    }
  }
  return total;
}

std::vector<std::string> FrameSource::Files() const {
  std::vector<std::string> files;
  for (const Input& input : inputs_) {
    if (input.kind == Kind::kImage || input.kind == Kind::kVideo) files.push_back(input.path);
  }
  return files;
}

bool FrameSource::at_camera() const {
  return next_ < inputs_.size() && inputs_[next_].kind == Kind::kCamera;
}

QuietStderr::QuietStderr() {
  std::fflush(stderr);
  const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (null < 0) return;
  saved_ = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  if (saved_ >= 0) dup2(null, STDERR_FILENO);
  close(null);
}

QuietStderr::~QuietStderr() {
  if (saved_ < 0) return;
  std::fflush(stderr);
  dup2(saved_, STDERR_FILENO);
  close(saved_);
}

}  // namespace topotag::tools
