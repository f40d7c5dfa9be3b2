#include <algorithm>
#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>
#include <utility>

#include "bench/peers.h"

namespace topotag::bench {
namespace {

// White cells around the black ones. With one, the outlines of paper and marker are so near to each
// other that the detector keeps the larger one only, and finds nothing.
constexpr int kBorder = 2;
constexpr int kMinSide = 16;  // of the black square where ArUco3 searches for it, pixels
constexpr double kMargin = 1.4;

/// ArUco3 searches a smaller frame: it is told how small a marker may be, by the formula of its
/// paper (minMarkerLengthRatioOriginalImg).
float Aruco3Ratio(const PeerSetup& setup, double black_share) {
  const double shrink = kMinSide * kMargin / (setup.min_side * black_share);
  return static_cast<float>(std::max(0.0, kMinSide * (1 / shrink - 1) / setup.frame_side));
}

cv::Ptr<cv::aruco::Dictionary> DictionaryOf250(int bits) {
  switch (bits) {
    case 4:
      return cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_250);
    case 5:
      return cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_250);
    default:
      return cv::aruco::getPredefinedDictionary(cv::aruco::DICT_6X6_250);
  }
}

class ArucoPeer : public Peer {
 public:
  ArucoPeer(int bits, bool aruco3, const PeerSetup& setup)
      : threads_(setup.threads),
        dictionary_(DictionaryOf250(bits)),
        parameters_(cv::aruco::DetectorParameters::create()) {
    if (!aruco3) return;
    const double black = dictionary_->markerSize + 2;
    parameters_->useAruco3Detection = true;
    parameters_->minSideLengthCanonicalImg = kMinSide;
    parameters_->minMarkerLengthRatioOriginalImg =
        Aruco3Ratio(setup, black / (black + 2 * kBorder));
  }

  void RefineCorners(cv::aruco::CornerRefineMethod method) {
    parameters_->cornerRefinementMethod = method;
  }

  std::string name() const override {
    if (parameters_->cornerRefinementMethod == cv::aruco::CORNER_REFINE_SUBPIX) return "ArUco/s";
    if (parameters_->cornerRefinementMethod == cv::aruco::CORNER_REFINE_APRILTAG) return "ArUco/a";
    return parameters_->useAruco3Detection ? "ArUco3" : "ArUco";
  }
  std::string description() const override {
    const std::string bits = std::to_string(dictionary_->markerSize);
    const std::string base = "OpenCV " CV_VERSION ", DICT_" + bits + "X" + bits + "_250, ";
    if (parameters_->cornerRefinementMethod == cv::aruco::CORNER_REFINE_SUBPIX) {
      return base + "CORNER_REFINE_SUBPIX";
    }
    if (!parameters_->useAruco3Detection) return base + "default parameters";
    return base + "useAruco3Detection, told the size of the smallest marker";
  }
  std::string dictionary() const override {
    const std::string bits = std::to_string(dictionary_->markerSize);
    return bits + "x" + bits + "_250";
  }
  int dictionary_size() const override { return dictionary_->bytesList.rows; }

  BitmapMarker Marker(int id) const override {
    const int black = dictionary_->markerSize + 2;
    cv::Mat image;
    cv::aruco::drawMarker(dictionary_, id, black, image, 1);
    BitmapMarker marker;
    marker.cells = black + 2 * kBorder;
    for (int y = -kBorder; y < black + kBorder; ++y) {
      for (int x = -kBorder; x < black + kBorder; ++x) {
        const bool border = x < 0 || y < 0 || x >= black || y >= black;
        marker.white.push_back(border || image.at<uint8_t>(y, x) != 0);
      }
    }
    return marker;
  }

  void Detect(const ImageView& image, std::vector<int>* ids) override {
    const cv::Mat view(image.height, image.width, CV_8UC1, const_cast<uint8_t*>(image.data),
                       static_cast<size_t>(image.stride));
    // The number of threads is the process's; nobody else here computes with OpenCV.
    if (cv::getNumThreads() != threads_) cv::setNumThreads(threads_);
    cv::aruco::detectMarkers(view, dictionary_, corners_, *ids, parameters_);
  }

  void Locate(const ImageView& image, std::vector<Located>* markers) override {
    std::vector<int> ids;
    Detect(image, &ids);
    markers->clear();
    for (size_t i = 0; i < ids.size(); ++i) {
      Located located;
      located.id = ids[i];
      for (size_t c = 0; c < 4; ++c) located.corners[c] = {corners_[i][c].x, corners_[i][c].y};
      markers->push_back(located);
    }
  }

  double black_share() const override {
    const double black = dictionary_->markerSize + 2;
    return black / (black + 2 * kBorder);
  }

 private:
  int threads_;
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
  cv::Ptr<cv::aruco::DetectorParameters> parameters_;
  std::vector<std::vector<cv::Point2f>> corners_;
};

}  // namespace

void AddAruco(const PeerSetup& setup, std::vector<std::unique_ptr<Peer>>* peers) {
  for (const bool aruco3 : {false, true}) {
    peers->push_back(std::make_unique<ArucoPeer>(6, aruco3, setup));
  }
}

void AddRefinedAruco(std::vector<std::unique_ptr<Peer>>* peers) {
  for (const auto method : {cv::aruco::CORNER_REFINE_SUBPIX, cv::aruco::CORNER_REFINE_APRILTAG}) {
    auto peer = std::make_unique<ArucoPeer>(6, false, PeerSetup());
    peer->RefineCorners(method);
    peers->push_back(std::move(peer));
  }
}

void AddAruco(int bits, bool refine, std::vector<std::unique_ptr<Peer>>* peers) {
  auto peer = std::make_unique<ArucoPeer>(bits, false, PeerSetup());
  if (refine) peer->RefineCorners(cv::aruco::CORNER_REFINE_SUBPIX);
  peers->push_back(std::move(peer));
}

}  // namespace topotag::bench
