#ifndef TOPOTAG_CAMERA_FILE_H_
#define TOPOTAG_CAMERA_FILE_H_

#include <string>

#include "topotag/camera.h"

namespace topotag {

/// Reads a calibration: OpenCV YAML or JSON (camera_matrix, distortion_coefficients, image_width,
/// image_height), ROS camera_info YAML (the same keys, distortion_model), or the TopoTag
/// authors' keys (cameraMatrix, distortionCoefficients). Matrices as nested lists, flat lists, or
/// rows/cols/data. 0, 4, 5, 8, 12 or 14 coefficients; distortion_model "equidistant" or "fisheye"
/// selects the fisheye model with 4. Without image_width and image_height the size is 0 x 0.
/// @throws Error (kFile: cannot be read; kParse: what is missing or malformed), naming the file
///         and the key.
Camera ReadCamera(const std::string& path);

/// Writes OpenCV YAML that ReadCamera and cv::FileStorage read back to the same values.
/// A failure leaves the old file or none, never a part of one.
/// @throws Error (kFile; kInvalidArgument as ValidateCamera).
void WriteCamera(const Camera& camera, const std::string& path);

}  // namespace topotag

#endif  // TOPOTAG_CAMERA_FILE_H_
