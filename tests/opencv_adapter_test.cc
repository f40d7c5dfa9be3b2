#include <gtest/gtest.h>

#include <string>

#include "topotag/opencv.h"

namespace topotag {
namespace {

// What ViewOf says about a matrix that it must refuse; empty where it accepts it.
std::string Refusal(const cv::Mat& mat) {
  try {
    ViewOf(mat);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kInvalidArgument);
    return e.what();
  }
  return "";
}

TEST(OpenCvAdapter, ViewsTheSamePixels) {
  cv::Mat mat(3, 5, CV_8UC1);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) mat.at<uint8_t>(y, x) = static_cast<uint8_t>(10 * y + x);
  }
  const ImageView view = ViewOf(mat);
  EXPECT_EQ(view.data, mat.data);
  EXPECT_EQ(view.width, 5);
  EXPECT_EQ(view.height, 3);
  EXPECT_EQ(view.row(2)[4], 24);
  EXPECT_NO_THROW(ValidateImage(view));
}

TEST(OpenCvAdapter, PartOfAMatrixKeepsItsStride) {
  cv::Mat whole(20, 30, CV_8UC1, cv::Scalar(0));
  whole.at<uint8_t>(12, 9) = 77;
  const ImageView view = ViewOf(whole(cv::Rect(7, 10, 4, 6)));
  EXPECT_EQ(view.width, 4);
  EXPECT_EQ(view.height, 6);
  EXPECT_EQ(view.stride, 30);
  EXPECT_EQ(view.row(2)[2], 77);
}

TEST(OpenCvAdapter, OneRowOfAMatrix) {
  cv::Mat whole(4, 6, CV_8UC1, cv::Scalar(0));
  whole.at<uint8_t>(3, 5) = 9;
  const ImageView view = ViewOf(whole.row(3));
  EXPECT_EQ(view.height, 1);
  EXPECT_EQ(view.row(0)[5], 9);
  EXPECT_NO_THROW(ValidateImage(view));
}

TEST(OpenCvAdapter, RefusesEveryOtherMatrix) {
  EXPECT_EQ(Refusal(cv::Mat()), "cv::Mat is empty");
  EXPECT_EQ(Refusal(cv::Mat(2, 2, CV_8UC3)), "cv::Mat is CV_8UC3, not CV_8UC1");
  EXPECT_EQ(Refusal(cv::Mat(2, 2, CV_8SC1)), "cv::Mat is CV_8SC1, not CV_8UC1");
  EXPECT_EQ(Refusal(cv::Mat(2, 2, CV_16UC1)), "cv::Mat is CV_16UC1, not CV_8UC1");
  const int sizes[] = {2, 2, 2};
  EXPECT_EQ(Refusal(cv::Mat(3, sizes, CV_8UC1)), "cv::Mat has 3 dimensions, not 2");
}

}  // namespace
}  // namespace topotag
