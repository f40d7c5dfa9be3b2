#ifndef TOPOTAG_OPENCV_H_
#define TOPOTAG_OPENCV_H_

// Optional, header only: for programs that use OpenCV themselves. The library does not need it.

#include <cstddef>
#include <opencv2/core.hpp>
#include <string>

#include "topotag/error.h"
#include "topotag/image.h"

namespace topotag {

/// The pixels of an 8-bit grayscale cv::Mat, a part of a larger one included; nothing is copied.
/// @param mat  CV_8UC1, two dimensions, not empty; it must outlive the view.
/// @throws Error (kInvalidArgument) that names what the matrix is instead.
inline ImageView ViewOf(const cv::Mat& mat) {
  if (mat.empty()) {
    throw Error(ErrorCode::kInvalidArgument, "cv::Mat is empty");
  }
  if (mat.dims != 2) {
    throw Error(ErrorCode::kInvalidArgument,
                "cv::Mat has " + std::to_string(mat.dims) + " dimensions, not 2");
  }
  if (mat.type() != CV_8UC1) {
    throw Error(ErrorCode::kInvalidArgument,
                "cv::Mat is " + cv::typeToString(mat.type()) + ", not CV_8UC1");
  }
  return {mat.data, mat.cols, mat.rows, static_cast<ptrdiff_t>(mat.step[0])};
}

}  // namespace topotag

#endif  // TOPOTAG_OPENCV_H_
