#include <cmath>
#include <cstdio>

#include "host/mean_side.h"
#include "host/one_line.h"
#include "tools/report_formats.h"

namespace topotag::tools {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

}  // namespace

std::string FormatText(const ExtraColumns& columns, const FrameResult& result) {
  const size_t count = result.detections.size();
  char line[256];
  std::string text = OneLine(result.image);
  if (result.is_sequence) text += " frame " + std::to_string(result.frame);
  std::snprintf(line, sizeof line, ": %dx%d, ", result.width, result.height);
  text += line;
  text += count == 0   ? "no marker\n"
          : count == 1 ? "1 marker\n"
                       : std::to_string(count) + " markers\n";
  for (size_t i = 0; i < count; ++i) {
    const Detection& detection = result.detections[i];
    std::snprintf(line, sizeof line, "  %s %-8s center (%.2f, %.2f)  side %.1f px",
                  detection.family.name().c_str(), IdText(detection).c_str(), detection.center.x,
                  detection.center.y, MeanSide(detection.corners.data()));
    text += line;
    if (detection.inverted) text += "  inverted";
    if (columns.track) text += "  track " + std::to_string(result.tracks[i].number);
    if (detection.pose) {
      const Pose& pose = *detection.pose;
      const double facing = std::fmin(1, std::fmax(-1, pose.R[2][2]));
      std::snprintf(line, sizeof line, "  t (%.4f, %.4f, %.4f) m  tilt %.1f deg  rms %.3f px",
                    pose.t[0], pose.t[1], pose.t[2], std::acos(facing) * kDegrees, pose.rms_px);
      text += line;
    }
    if (columns.quality) {
      const Quality& quality = detection.quality;
      std::snprintf(line, sizeof line,
                    "  contrast %.1f  decision %.2f  sharpness %.2f  fit %.3f px", quality.contrast,
                    quality.decision, quality.sharpness, quality.rms_px);
      text += line;
    }
    text += "\n";
  }
  if (!result.objects) return text;
  for (const FoundObject& object : *result.objects) {
    const ObjectPose& pose = object.pose;
    text += "  object " + OneLine(object.name);
    std::snprintf(line, sizeof line,
                  "  t (%.4f, %.4f, %.4f) m  rms %.3f px  from %zu of its markers", pose.t[0],
                  pose.t[1], pose.t[2], pose.rms_px, pose.used.size());
    text += line;
    if (!pose.rejected.empty()) text += ", " + std::to_string(pose.rejected.size()) + " rejected";
    text += "\n";
  }
  return text;
}

}  // namespace topotag::tools
