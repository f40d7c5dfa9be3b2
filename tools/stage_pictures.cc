#include "tools/stage_pictures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "host/stages.h"
#include "tools/draw.h"

namespace topotag::tools {
namespace {

cv::Mat AsMat(const ImageView& image) {
  return cv::Mat(image.height, image.width, CV_8UC1, const_cast<uint8_t*>(image.data),
                 static_cast<size_t>(image.stride));
}

/// Neighbouring labels get unlike colours, the same in every run.
cv::Vec3b LabelColor(uint32_t label, bool is_white) {
  uint32_t hash = label * 2654435761u;
  hash ^= hash >> 15;
  hash *= 2246822519u;
  hash ^= hash >> 13;
  const int low = is_white ? 130 : 20;
  const int range = is_white ? 126 : 80;
  cv::Vec3b color;
  for (int channel = 0; channel < 3; ++channel) {
    color[channel] =
        static_cast<uchar>(low + static_cast<int>(hash >> (8 * channel) & 255) * range / 256);
  }
  return color;
}

cv::Mat ComponentPicture(const std::vector<uint32_t>& labels, const cv::Mat& binary) {
  cv::Mat picture(binary.size(), CV_8UC3, cv::Scalar(0, 0, 0));
  const auto width = static_cast<size_t>(binary.cols);
  for (int y = 0; y < binary.rows; ++y) {
    for (int x = 0; x < binary.cols; ++x) {
      const uint32_t label = labels[static_cast<size_t>(y) * width + static_cast<size_t>(x)];
      // 0 is what surrounds the frame: it stays black.
      if (label == 0) continue;
      picture.at<cv::Vec3b>(y, x) = LabelColor(label, binary.at<uchar>(y, x) != 0);
    }
  }
  return picture;
}

void DrawBoxes(const std::vector<Rect>& boxes, const cv::Scalar& color, cv::Mat* picture) {
  const double scale = PictureScale(picture->cols, picture->rows);
  for (const Rect& box : boxes) {
    const double side = std::min(box.width, box.height);
    const int width =
        std::max(1, static_cast<int>(std::lround(std::clamp(side / 30, 1.0, 2 * scale))));
    cv::rectangle(*picture, cv::Rect(box.x, box.y, box.width, box.height), color, width);
  }
}

/// The dimmed bit image with the candidates' boxes in yellow, in blue those of the areas that were
/// looked at again.
cv::Mat CandidatePicture(const DetectorStages& stages, const cv::Mat& binary) {
  cv::Mat picture;
  cv::cvtColor(binary * 0.5, picture, cv::COLOR_GRAY2BGR);
  DrawBoxes(stages.Doubts(), {255, 128, 0}, &picture);
  DrawBoxes(stages.Candidates(), {0, 225, 255}, &picture);
  return picture;
}

}  // namespace

std::vector<PictureFolder::Picture> StagePictures(const Detector& detector, const ImageView& frame,
                                                  const cv::Mat& result) {
  const Rect roi = detector.options().roi.value_or(Rect{0, 0, frame.width, frame.height});
  const cv::Rect area(roi.x, roi.y, roi.width, roi.height);
  const DetectorStages stages(detector);
  const Image thresholds = stages.ThresholdMap();
  const Image binary = stages.Binary();
  const cv::Mat bits = AsMat(binary.view());
  return {{"_1_input", AsMat(frame)(area)},
          {"_2_threshold", AsMat(thresholds.view()).clone()},
          {"_3_binary", bits.clone()},
          {"_4_components", ComponentPicture(stages.Labels(), bits)},
          {"_5_candidates", CandidatePicture(stages, bits)},
          {"_6_result", result(area)}};
}

}  // namespace topotag::tools
