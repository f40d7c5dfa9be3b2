#ifndef TOPOTAG_TOOLS_STAGE_PICTURES_H_
#define TOPOTAG_TOOLS_STAGE_PICTURES_H_

#include <opencv2/core.hpp>
#include <vector>

#include "tools/output.h"
#include "topotag/detector.h"

namespace topotag::tools {

/// A picture of each stage of the detector's last frame, within its region of interest: input,
/// threshold map, bit image, components (a colour each, bright where white), candidates of the
/// tree, result.
/// @param result  the annotated frame.
std::vector<PictureFolder::Picture> StagePictures(const Detector& detector, const ImageView& frame,
                                                  const cv::Mat& result);

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_STAGE_PICTURES_H_
