#ifndef TOPOTAG_TOOLS_DRAW_H_
#define TOPOTAG_TOOLS_DRAW_H_

#include <opencv2/core.hpp>
#include <vector>

#include "topotag/detection.h"
#include "topotag/image.h"
#include "topotag/options.h"

namespace topotag::tools {

/// The frame in colour (BGR) with each marker's outline, first corner, family and ID, vertices
/// and, where it has a pose, its axes (x red, y green, z blue). Lines and text grow with the
/// frame and the marker.
/// @param options  those of the detector: camera, and sizes, which the length of the axes follows
cv::Mat DrawDetections(const ImageView& image, const std::vector<Detection>& detections,
                       const Options& options);

/// The axes of a pose, drawn over a picture.
/// @param length  metres
void DrawPoseAxes(cv::Mat* picture, const Pose& pose, const Camera& camera, double length);

/// Lines and text are made for pictures that are looked at about 1280 pixels wide.
double PictureScale(int width, int height);

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_DRAW_H_
