#ifndef TOPOTAG_HOST_DETECTOR_IMPL_H_
#define TOPOTAG_HOST_DETECTOR_IMPL_H_

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "host/backend.h"
#include "host/decode.h"
#include "host/far.h"
#include "host/far_outline.h"
#include "host/frame_source.h"
#include "host/ids.h"
#include "host/nodes.h"
#include "host/one_thread.h"
#include "host/photometric.h"
#include "host/pre_blur.h"
#include "host/segmentation.h"
#include "host/upsample.h"
#include "host/workers.h"
#include "topotag/detector.h"

namespace topotag {

/// A marker in the making.
struct Marker {
  bool is_read;  ///< its candidate was one
  Decoded decoded;
  Point2 center;  ///< pixels
  VertexList vertices;
  FarReading far;  ///< of those read by matched filters
};

/// A frame that was submitted and not collected.
struct Pending {
  ImageView image;
  Rect area;
  int min_contrast;  ///< of its ThresholdParams
};

/// The part of a frame that is looked at.
inline ImageView Crop(const ImageView& image, const Rect& area) {
  return {image.row(area.y) + area.x, area.width, area.height, image.stride};
}

/// Pixels of the white square's corners, as Detection::corners.
inline std::array<Point2, 4> WhiteCorners(const TagMap& map, Family family) {
  const double half = family.white_side() / 2.0;
  return {map.Pixel({-half, -half}), map.Pixel({half, -half}), map.Pixel({half, half}),
          map.Pixel({-half, half})};
}

/// A call of a detector by its user.
struct DetectorUse : OneThread::Use {
  explicit DetectorUse(OneThread* detector) : Use(detector, "the detector") {}
};

/// A detector's configuration and the workspace of its last frame.
struct Detector::Impl {
  explicit Impl(Options o);

  /// The part of the frame that is searched. Throws where the frame does not fit the options.
  Rect Area(const ImageView& image) const;
  const Camera* camera() const { return options.camera ? &*options.camera : nullptr; }
  double TagSize(Family family, uint64_t id) const;

  /// Where the next frame comes from; null: host memory. Before anything is begun with that frame:
  /// a failure leaves everything as it is.
  void TakeFrom(FrameSource* from);
  /// Everything that is done with a frame of which `area` is searched.
  void Detect(const ImageView& image, const Rect& area, std::vector<Detection>* detections);
  void Search(const ImageView& image, const Rect& whole);
  void FetchCandidates(const Rect& whole);
  ImageView Enlarged(const ImageView& image, const Rect& part, int* scale);
  void LookAgain(const ImageView& image, const Rect& whole, const Rect& part, bool has_holes);
  void DecodeCandidates(const ImageView& image, const Segmentation& segmentation,
                        const SearchArea& area);
  void ReadFar(const ImageView& image, const Rect& whole);
  bool IsFar(const Marker* marker) const { return marker >= markers.data() + far_begin; }
  void LookIntoShade(const ImageView& image, const Rect& whole);
  void LookAround(const ImageView& image, const Rect& whole, const Rect& part, Point2 start,
                  int contrast_sixteenths);
  void ReadBrokenNodes(const ImageView& image, Point2 start, const SearchArea& area);
  /// The frame as it is searched. Those that are submitted stay as they are.
  ImageView Prepared(const ImageView& image);
  void KeepMarker(size_t i);
  bool ReadBroken(const ImageView& image, const Node* nodes, int count, Point2 start,
                  const SearchArea& area, Marker* marker) const;
  void MeasureVertices(const ImageView& image);
  void Report(std::vector<Detection>* detections);
  void EstimatePoses(std::vector<Detection>* detections);
  void RefinePoses(const ImageView& image, std::vector<Detection>* detections);

  OneThread one_thread;
  Options options;
  ThresholdParams threshold_params;
  Workers workers;
  std::unique_ptr<Backend> backend;
  std::unique_ptr<Backend> second_backend;  ///< of the second looks
  std::string backend_name;                 ///< of the last frame
  FrameSource* source = nullptr;            ///< of the last frame
  std::unique_ptr<FrameSource> device_frames;
  std::vector<Pending> pending;  ///< oldest first
  std::vector<Rect> parts;       ///< to fetch from the source
  StageTimes times;

  Segmentation first;    ///< of the whole area
  Segmentation second;   ///< of one doubtful part of it
  NodeCollector broken;  ///< all nodes of that part
  IdsInUse ids;
  std::array<PreBlurWorkspace, kMaxSubmitted> smoothed;
  size_t next_smoothed = 0;
  UpsampleWorkspace upsampled;
  std::optional<FarSearch> far;
  FarOutline outline;           ///< of white areas that may hold far markers
  std::vector<Marker> markers;  ///< never shrinks: the first marker_count ones are in use
  size_t marker_count = 0;
  size_t broken_left = 0;            ///< how many broken markers may still be tried
  std::vector<size_t> unread;        ///< candidates that are tried as such
  size_t far_begin = 0;              ///< from which on they were read by matched filters
  std::vector<const Marker*> order;  ///< in which they are reported
  std::vector<PhotometricWorkspace> photometric;  ///< of each thread
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_DETECTOR_IMPL_H_
