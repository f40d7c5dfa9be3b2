#ifndef TOPOTAG_HOST_DETECTOR_IMPL_H_
#define TOPOTAG_HOST_DETECTOR_IMPL_H_

#include <memory>
#include <string>
#include <vector>

#include "host/backend.h"
#include "host/decode.h"
#include "host/frame_source.h"
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
};

/// A frame that was submitted and not collected.
struct Pending {
  ImageView image;
  Rect area;
};

/// A detector's configuration and the workspace of its last frame.
struct Detector::Impl {
  explicit Impl(Options o);

  /// The part of the frame that is searched. Throws where the frame does not fit the options.
  Rect Area(const ImageView& image) const;
  const Camera* camera() const { return options.camera ? &*options.camera : nullptr; }
  double TagSize(Family family, uint64_t id) const;

  /// Everything that is done with a frame of which `area` is searched. `from` is null for frames in
  /// host memory.
  void Detect(FrameSource* from, const ImageView& image, const Rect& area,
              std::vector<Detection>* detections);
  void Search(const ImageView& image, const Rect& whole);
  void FetchCandidates(const Rect& whole);
  void LookAgain(const ImageView& image, const Rect& whole, const Rect& part);
  void DecodeCandidates(const ImageView& image, const Segmentation& segmentation,
                        const SearchArea& area);
  void MeasureVertices(const ImageView& image);
  void Report(std::vector<Detection>* detections);
  void EstimatePoses(std::vector<Detection>* detections);

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

  Segmentation first;   ///< of the whole area
  Segmentation second;  ///< of one doubtful part of it
  UpsampleWorkspace upsampled;
  std::vector<Marker> markers;  ///< never shrinks: the first marker_count ones are in use
  size_t marker_count = 0;
  std::vector<const Marker*> order;  ///< in which they are reported
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_DETECTOR_IMPL_H_
