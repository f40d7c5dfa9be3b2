#ifndef TOPOTAG_HOST_REGION_SEARCH_H_
#define TOPOTAG_HOST_REGION_SEARCH_H_

#include <memory>
#include <string>
#include <vector>

#include "topotag/detector.h"

namespace topotag {

/// Searches parts of frames as a detector searches whole ones. Each part is one thread's work, with
/// a workspace of its own: shared by several threads, small parts would mostly wait. The results do
/// not depend on the number of threads.
class RegionSearch {
 public:
  /// @param detector  whose options count, and whose threads do the work
  explicit RegionSearch(Detector* detector);
  ~RegionSearch();

  /// What Detector::detect searches of this frame.
  /// @throws Error as that
  Rect Area(const ImageView& image) const;

  /// The detections in all regions, which lie within the frame's area, in Detector's order, less
  /// those near to the border of a region: something that was not searched may have a part in them.
  void Run(const ImageView& image, const std::vector<Rect>& regions,
           std::vector<Detection>* detections);

  const std::string& backend() const;
  /// Of the last frame, sums over its regions.
  const StageTimes& times() const { return times_; }

 private:
  struct Engine;

  /// Everything of one region.
  void Search(const ImageView& image, const Rect& region, Engine* engine);

  Detector& detector_;
  std::vector<std::unique_ptr<Engine>> engines_;  ///< of each thread
  std::vector<const Detection*> order_;
  StageTimes times_;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_REGION_SEARCH_H_
