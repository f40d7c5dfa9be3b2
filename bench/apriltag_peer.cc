#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include "bench/peers.h"

namespace topotag::bench {
namespace {

class AprilTagPeer : public Peer {
 public:
  AprilTagPeer(int decimate, int threads)
      : decimate_(decimate),
        family_(tag36h11_create(), tag36h11_destroy),
        detector_(apriltag_detector_create(), apriltag_detector_destroy) {
    detector_->quad_decimate = static_cast<float>(decimate);
    detector_->nthreads = threads;
    apriltag_detector_add_family(detector_.get(), family_.get());
  }

  std::string name() const override { return "AprilTag d" + std::to_string(decimate_); }
  std::string description() const override {
    return "AprilTag " TOPOTAG_BENCH_APRILTAG_VERSION ", 36h11, quad_decimate " +
           std::to_string(decimate_);
  }
  std::string dictionary() const override { return "36h11"; }

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
    // The library takes a pointer to changeable pixels and does not change them.
    image_u8_t view{image.width, image.height, static_cast<int32_t>(image.stride),
                    const_cast<uint8_t*>(image.data)};
    zarray_t* detections = apriltag_detector_detect(detector_.get(), &view);
    ids->clear();
    for (int i = 0; i < zarray_size(detections); ++i) {
      apriltag_detection_t* detection = nullptr;
      zarray_get(detections, i, &detection);
      ids->push_back(detection->id);
    }
    apriltag_detections_destroy(detections);
  }

 private:
  int decimate_;
  std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family_;
  std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector_;
};

}  // namespace

void AddAprilTag(const PeerSetup& setup, std::vector<std::unique_ptr<Peer>>* peers) {
  for (const int decimate : {1, 2}) {
    peers->push_back(std::make_unique<AprilTagPeer>(decimate, setup.threads));
  }
}

}  // namespace topotag::bench
