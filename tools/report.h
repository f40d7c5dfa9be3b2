#ifndef TOPOTAG_TOOLS_REPORT_H_
#define TOPOTAG_TOOLS_REPORT_H_

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/object_finder.h"
#include "topotag/detector.h"
#include "topotag/tracker.h"

namespace topotag::tools {

enum class Format { kText, kJson, kCsv };

/// What was found in one frame.
struct FrameResult {
  std::string image;
  int64_t frame = 0;
  bool is_sequence = false;  ///< one of many frames of the same input
  int width = 0;
  int height = 0;
  std::string backend;
  std::vector<Detection> detections;
  std::optional<std::vector<FoundObject>> objects;  ///< where any were asked for
  std::vector<TrackState> tracks;                   ///< of the detections, where they are tracked
  StageTimes times;
};

/// What is told of each marker beside what always is.
struct ExtraColumns {
  bool inverted;  ///< in CSV; elsewhere it is told where a marker is
  bool quality;
  bool track;
};

/// What comes before the first frame; may be empty.
std::string FormatHeader(Format format, const ExtraColumns& columns);
/// The lines of one frame, each with its line feed.
std::string FormatFrame(Format format, const ExtraColumns& columns, const FrameResult& result);

/// The keys that the output of detect and the truth of render have in common: image, frame,
/// width, height. Pixels to 1e-6, other numbers to 9 significant digits.
nlohmann::ordered_json FrameJson(const std::string& image, int64_t frame, int width, int height);
/// family, id, center, corners, vertices, without the pose.
nlohmann::ordered_json MarkerJson(const Detection& detection);
/// R and t.
nlohmann::ordered_json TransformJson(const PoseSolution& pose);
/// One line without its line feed; text that is not UTF-8 is replaced.
std::string Dump(const nlohmann::ordered_json& json);

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_REPORT_H_
