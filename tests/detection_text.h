#ifndef TOPOTAG_TESTS_DETECTION_TEXT_H_
#define TOPOTAG_TESTS_DETECTION_TEXT_H_

#include <cstdio>
#include <string>
#include <vector>

#include "topotag/detection.h"

namespace topotag {

/// Every bit of detections as text, so that a difference can be read.
class DetectionText {
 public:
  explicit DetectionText(const std::vector<Detection>& detections) {
    for (const Detection& d : detections) Add(d);
  }
  const std::string& str() const { return text_; }

 private:
  void Add(const char* name) { text_ += name; }
  void Add(double value) {
    char digits[40];
    std::snprintf(digits, sizeof(digits), " %a", value);
    text_ += digits;
  }
  void Add(const Point2& p) {
    Add(p.x);
    Add(p.y);
  }
  void Add(const PoseSolution& solution) {
    for (const auto& row : solution.R) {
      for (const double value : row) Add(value);
    }
    for (const double value : solution.t) Add(value);
    Add(solution.rms_px);
  }
  void Add(const Photometric& p) {
    Add(p.accepted ? "\naccepted" : "\nrejected");
    for (const double value : {p.sigma, p.noise, p.blur_px, p.black, p.white, p.growth}) Add(value);
    Add(static_cast<double>(p.pixels));
  }
  void Add(const Pose& pose) {
    Add("\npose");
    Add(static_cast<const PoseSolution&>(pose));
    Add("\ncovariance");
    for (const auto& row : pose.covariance) {
      for (const double value : row) Add(value);
    }
    if (pose.alternative) {
      Add("\nalternative");
      Add(*pose.alternative);
    }
    Add(pose.ambiguity);
    if (pose.photometric) Add(*pose.photometric);
  }
  void Add(const Detection& d) {
    text_ += d.family.name() + " " + std::to_string(d.id) + " of which unknown " +
             std::to_string(d.unknown_bits) + (d.inverted ? " inverted" : "") + "\ncenter";
    Add(d.center);
    Add("\ncorners");
    for (const Point2& p : d.corners) Add(p);
    Add("\nvertices");
    for (const Point2& p : d.vertices) Add(p);
    if (d.margin) {
      Add("\nmargin");
      Add(*d.margin);
    }
    Add("\nquality");
    const Quality& q = d.quality;
    for (const double value : {q.contrast, q.decision, q.sharpness, q.rms_px}) Add(value);
    if (d.pose) Add(*d.pose);
    text_ += "\n";
  }

  std::string text_;
};

}  // namespace topotag

#endif  // TOPOTAG_TESTS_DETECTION_TEXT_H_
