#ifndef TOPOTAG_HOST_DETECTOR_IMPL_H_
#define TOPOTAG_HOST_DETECTOR_IMPL_H_

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "host/backend.h"
#include "host/buffer.h"
#include "host/decode.h"
#include "host/far.h"
#include "host/far_outline.h"
#include "host/frame_source.h"
#include "host/ids.h"
#include "host/nodes.h"
#include "host/one_thread.h"
#include "host/photometric.h"
#include "host/place_grid.h"
#include "host/pre_blur.h"
#include "host/segmentation.h"
#include "host/upsample.h"
#include "host/workers.h"
#include "topotag/detector.h"

namespace topotag {

/// A marker in the making.
struct Marker {
  bool is_read;      ///< its candidate was one
  bool is_far;       ///< read by matched filters
  bool is_inverted;  ///< read in the complement
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

/// A frame and, where markers were read in it, its complement: 255 less its grey levels.
struct FrameViews {
  ImageView image, complement;
  const ImageView& Of(bool inverted) const { return inverted ? complement : image; }
};

/// One search: of a frame, or of its complement.
struct SearchPass {
  Backend* backend;
  Segmentation* segmentation;  ///< of the whole area
  FrameSource* source;         ///< null where the pixels are in host memory
  bool inverted;
  size_t first_marker;
};

/// What the search of the complement has of its own. Never on a device.
struct ComplementSearch {
  ComplementSearch(BackendKind kind, Workers* workers, const TreeParams& params)
      : backend(MakeSecondBackend(kind, workers)), segmentation(params) {}

  std::unique_ptr<Backend> backend;
  Segmentation segmentation;
};

/// The part of a frame that is looked at.
inline ImageView Crop(const ImageView& image, const Rect& area) {
  return {image.row(area.y) + area.x, area.width, area.height, image.stride};
}

/// A box grown by the margin of what decoding and refining read around it, within the frame.
Rect WithMargin(const Rect& box, const ImageView& frame);

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

  /// Where the next frame comes from; null: host memory. Before anything is begun with that frame:
  /// a failure leaves everything as it is.
  void TakeFrom(FrameSource* from);
  /// Of the next frame, or of the last one.
  Backend* CurrentBackend() const { return source == nullptr ? backend.get() : source->backend(); }
  /// Everything that is done with a frame of which `area` is searched; the backend may have begun
  /// with it. After an error there are no detections, and the backend is left with the frames of
  /// `pending`.
  void Detect(const ImageView& image, const Rect& area, std::vector<Detection>* detections);
  void RunStages(const ImageView& image, const Rect& area, std::vector<Detection>* detections);
  void Search(const ImageView& image, const Rect& whole);
  void FetchCandidates(const Rect& whole);
  /// Again where there is doubt, within limits of time.
  void SecondLooks(const ImageView& image, const Rect& whole);
  ImageView Enlarged(const ImageView& image, const Rect& part, int* scale);
  void LookAgain(const ImageView& image, const Rect& whole, const Rect& part, bool has_holes);
  void DecodeCandidates(const ImageView& image, const Segmentation& segmentation,
                        const SearchArea& area);
  void ReadFar(const ImageView& image, const Rect& whole);
  void LookIntoShade(const ImageView& image, const Rect& whole);
  void LookAround(const ImageView& image, const Rect& whole, const Rect& part, Point2 start,
                  int contrast_sixteenths);
  void ReadBrokenNodes(const ImageView& image, Point2 start, const SearchArea& area);
  /// The frame as it is searched. Those that are submitted stay as they are.
  ImageView Prepared(const ImageView& image);
  /// The complement of the part of a frame that is read where markers within `part` are, at the
  /// same coordinates; the rest of it is unspecified.
  ImageView Complement(const ImageView& image, const Rect& part);
  void KeepMarker(size_t i, bool is_far);
  /// Where the marker of a baseline node may reach to; empty where it is too small.
  Rect ReachOf(const LostBaseline& lost, const Rect& whole) const;
  bool ReadBroken(const ImageView& image, const Node* nodes, int count, Point2 start,
                  const SearchArea& area, Marker* marker) const;
  void MeasureVertices(const FrameViews& frame);
  void Report(std::vector<Detection>* detections);
  void EstimatePoses(std::vector<Detection>* detections);
  void RefinePoses(const FrameViews& frame, std::vector<Detection>* detections);

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
  std::optional<ComplementSearch> complement_search;
  Buffer<uint8_t> complement;
  SearchPass pass{};
  std::optional<FarSearch> far;
  FarOutline outline;           ///< of white areas that may hold far markers
  std::vector<Marker> markers;  ///< never shrinks: the first marker_count ones are in use
  size_t marker_count = 0;
  PlaceGrid places;                               ///< of the markers in use
  size_t broken_left = 0;                         ///< how many broken markers may still be tried
  std::vector<size_t> unread;                     ///< candidates that are tried as such
  std::vector<const Marker*> order;               ///< in which they are reported
  std::vector<PhotometricWorkspace> photometric;  ///< of each thread
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_DETECTOR_IMPL_H_
