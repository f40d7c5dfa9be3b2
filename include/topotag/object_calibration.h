#ifndef TOPOTAG_OBJECT_CALIBRATION_H_
#define TOPOTAG_OBJECT_CALIBRATION_H_

#include <vector>

#include "topotag/camera.h"
#include "topotag/object.h"

namespace topotag {

/// One picture of an object. The more exact the detections (PoseMode::kPhotometric), the better.
struct ObjectView {
  Camera camera;
  std::vector<Detection> detections;
};

/// What fixes the frame of a calibrated object.
enum class ObjectFrame {
  kFirstMarker,  ///< the first marker keeps its pose; the other poses are not used
  kAllMarkers,   ///< the markers lie, in the mean of squares, as near to their poses as can be
};

struct ObjectCalibration {
  Object object;  ///< the same markers in the same order, with their poses
  /// Of each marker's pose in the object's frame: (rotation vector [rad], translation [m]),
  /// R' = exp(w) R, t' = t + dt.
  std::vector<Matrix6> covariance;
  std::vector<int> sightings;  ///< of each marker: views that it was measured in
  int views = 0;               ///< that were used
  int rejected = 0;            ///< detections of the object's markers that contradict the others
  double rms_px = 0;           ///< root mean square reprojection error of the vertices
};

/// Measures where the markers are on an object, from views of it in many positions (or of one room
/// from many): bundle adjustment of all markers and views. Only the markers' IDs and sizes need to
/// be known; the sizes also fix the scale.
///
/// Start: relative poses of markers that are seen together, those that most views agree with,
/// in chains from the first marker. A marker that is seen twice in a view is left out there.
///
/// The time grows with the third power of the number of markers: 18 in 40 views take 0.05 s, 100 in
/// 20 views 1 s.
/// @param start  the markers; their poses say, with `frame`, what the object's frame is
/// @throws Error (kInvalidArgument) as ValidateObject and ValidateCamera; where there is one marker
///         only, or no view; where a marker is in no view, in none together with the others, or in
///         none agrees with them: the message names it.
ObjectCalibration CalibrateObject(const Object& start, const std::vector<ObjectView>& views,
                                  ObjectFrame frame = ObjectFrame::kFirstMarker);

}  // namespace topotag

#endif  // TOPOTAG_OBJECT_CALIBRATION_H_
