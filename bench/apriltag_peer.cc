#include <apriltag/apriltag.h>
#include <apriltag/apriltag_pose.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>

#include <cstdlib>

#include "bench/peers.h"

namespace topotag::bench {
namespace {

struct ZarrayDelete {
  void operator()(zarray_t* detections) const { apriltag_detections_destroy(detections); }
};
using Detections = std::unique_ptr<zarray_t, ZarrayDelete>;

size_t Count(const Detections& detections) {
  return detections ? static_cast<size_t>(zarray_size(detections.get())) : 0;
}

apriltag_detection_t* Get(const Detections& detections, size_t i) {
  apriltag_detection_t* detection = nullptr;
  zarray_get(detections.get(), static_cast<int>(i), &detection);
  return detection;
}

using Tags = std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)>;

Tags CreateTags(AprilTagFamily family) {
  switch (family) {
    case AprilTagFamily::k16h5:
      return {tag16h5_create(), tag16h5_destroy};
    case AprilTagFamily::k25h9:
      return {tag25h9_create(), tag25h9_destroy};
    default:
      return {tag36h11_create(), tag36h11_destroy};
  }
}

class AprilTagPeer : public Peer {
 public:
  AprilTagPeer(AprilTagFamily family, int decimate, int threads)
      : decimate_(decimate),
        family_(CreateTags(family)),
        detector_(apriltag_detector_create(), apriltag_detector_destroy) {
    detector_->quad_decimate = static_cast<float>(decimate);
    detector_->nthreads = threads;
    apriltag_detector_add_family(detector_.get(), family_.get());
  }

  std::string name() const override { return "AprilTag d" + std::to_string(decimate_); }
  std::string description() const override {
    return "AprilTag " TOPOTAG_BENCH_APRILTAG_VERSION ", " + dictionary() + ", quad_decimate " +
           std::to_string(decimate_);
  }
  // Of "tag36h11".
  std::string dictionary() const override { return std::string(family_->name).substr(3); }
  int dictionary_size() const override { return static_cast<int>(family_->ncodes); }

  BitmapMarker Marker(int id) const override {
    image_u8_t* image = apriltag_to_image(family_.get(), static_cast<uint32_t>(id));
    BitmapMarker marker;
    marker.cells = image->width;
    for (int y = 0; y < image->height; ++y) {
      for (int x = 0; x < image->width; ++x) {
        marker.white.push_back(image->buf[y * image->stride + x] != 0);
      }
    }
    image_u8_destroy(image);
    return marker;
  }

  void Detect(const ImageView& image, std::vector<int>* ids) override {
    Search(image);
    ids->clear();
    for (size_t i = 0; i < Count(detections_); ++i) ids->push_back(Get(detections_, i)->id);
  }

  void Locate(const ImageView& image, std::vector<Located>* markers) override {
    Search(image);
    markers->clear();
    for (size_t i = 0; i < Count(detections_); ++i) {
      const apriltag_detection_t* detection = Get(detections_, i);
      Located located;
      located.id = detection->id;
      // The library's corners begin at the bottom left and turn the other way; its pixels have
      // their centres at halves.
      for (size_t c = 0; c < 4; ++c) {
        const double* p = detection->p[3 - c];
        located.corners[c] = {p[0] - 0.5, p[1] - 0.5};
      }
      markers->push_back(located);
    }
  }

  std::optional<PoseSolution> OwnPose(size_t index, const Camera& camera, double side) override {
    apriltag_detection_info_t info{Get(detections_, index), side,           camera.fx, camera.fy,
                                   camera.cx + 0.5,         camera.cy + 0.5};
    apriltag_pose_t estimate{};
    estimate_tag_pose(&info, &estimate);
    PoseSolution pose;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) pose.R[i][j] = MATD_EL(estimate.R, i, j);
      pose.t[i] = MATD_EL(estimate.t, i, 0);
    }
    // What matd_destroy does, which not every package exports.
    std::free(estimate.R);
    std::free(estimate.t);
    return pose;
  }

  double black_share() const override {
    return static_cast<double>(family_->width_at_border) / family_->total_width;
  }

 private:
  void Search(const ImageView& image) {
    // The library takes a pointer to changeable pixels and does not change them.
    image_u8_t view{image.width, image.height, static_cast<int32_t>(image.stride),
                    const_cast<uint8_t*>(image.data)};
    detections_.reset(apriltag_detector_detect(detector_.get(), &view));
  }

  int decimate_;
  Tags family_;
  std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector_;
  Detections detections_;
};

}  // namespace

void AddAprilTag(const PeerSetup& setup, std::vector<std::unique_ptr<Peer>>* peers) {
  for (const int decimate : {1, 2}) {
    peers->push_back(
        std::make_unique<AprilTagPeer>(AprilTagFamily::k36h11, decimate, setup.threads));
  }
}

void AddAprilTag(AprilTagFamily family, std::vector<std::unique_ptr<Peer>>* peers) {
  peers->push_back(std::make_unique<AprilTagPeer>(family, 1, 1));
}

}  // namespace topotag::bench
