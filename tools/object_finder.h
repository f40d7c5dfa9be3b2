#ifndef TOPOTAG_TOOLS_OBJECT_FINDER_H_
#define TOPOTAG_TOOLS_OBJECT_FINDER_H_

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "topotag/detector.h"
#include "topotag/object.h"

namespace topotag::tools {

/// An object that was found in a frame; its indices are those of the frame's detections.
struct FoundObject {
  std::string name;
  ObjectPose pose;
};

/// Adds to the options the families and sizes of an object's markers.
void SetObjectOptions(const Object& object, Options* options);

/// The objects of `detect --object`.
class ObjectFinder {
 public:
  /// Reads the files.
  /// @throws UsageError "--object: reason", where a file is wrong or two objects share a name or a
  ///         marker.
  explicit ObjectFinder(const std::vector<std::string>& files);

  /// What the detector must know: the families and the size of each marker.
  /// @param choose  whether families may be added; else one that is missing is an error
  /// @throws UsageError
  void SetOptions(bool choose, Options* options) const;
  /// After SetOptions, and once there is a camera.
  void SetCamera(const Camera& camera);

  bool empty() const { return objects_.empty(); }
  void Find(const std::vector<Detection>& detections, std::vector<FoundObject>* found);
  /// The axes of what was found, as long as the object is wide.
  void Draw(const std::vector<FoundObject>& found, const Camera& camera, cv::Mat* picture) const;

 private:
  std::vector<Object> objects_;
  std::vector<ObjectPoseEstimator> estimators_;
};

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_OBJECT_FINDER_H_
