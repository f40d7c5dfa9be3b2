#include "tools/report_formats.h"

namespace topotag::tools {
namespace {

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string CsvNumber(double value) { return nlohmann::json(value).dump(); }

// 13 fields, each after a comma.
std::string CsvPose(const PoseSolution& pose) {
  std::string row;
  const auto add = [&row](double value) { row += "," + CsvNumber(Significant(value)); };
  for (const double value : pose.t) add(value);
  for (const auto& values : pose.R) {
    for (const double value : values) add(value);
  }
  add(pose.rms_px);
  return row;
}

}  // namespace

std::string CsvHeader(const ExtraColumns& columns) {
  std::string header =
      "image,frame,family,id,center_x,center_y,corner0_x,corner0_y,corner1_x,corner1_y,"
      "corner2_x,corner2_y,corner3_x,corner3_y,tx,ty,tz,r00,r01,r02,r10,r11,r12,r20,r21,r22,"
      "rms_px";
  if (columns.inverted) header += ",inverted";
  if (columns.quality) header += ",contrast,decision,sharpness,fit_px";
  if (columns.track) header += ",track";
  return header + "\n";
}

std::string FormatCsv(const ExtraColumns& columns, const FrameResult& result) {
  std::string rows;
  for (size_t i = 0; i < result.detections.size(); ++i) {
    const Detection& detection = result.detections[i];
    std::string row = CsvField(result.image) + "," + std::to_string(result.frame) + "," +
                      detection.family.name() + "," + IdText(detection);
    const auto add = [&row](double value) { row += "," + CsvNumber(value); };
    add(Pixels(detection.center.x));
    add(Pixels(detection.center.y));
    for (const Point2& corner : detection.corners) {
      add(Pixels(corner.x));
      add(Pixels(corner.y));
    }
    row += detection.pose ? CsvPose(*detection.pose) : std::string(13, ',');
    if (columns.inverted) row += detection.inverted ? ",1" : ",0";
    if (columns.quality) {
      const Quality& quality = detection.quality;
      for (const double value :
           {quality.contrast, quality.decision, quality.sharpness, quality.rms_px}) {
        add(Significant(value));
      }
    }
    if (columns.track) row += "," + std::to_string(result.tracks[i].number);
    rows += row + "\n";
  }
  if (!result.objects) return rows;
  // No place in the picture.
  for (const FoundObject& object : *result.objects) {
    rows += CsvField(result.image) + "," + std::to_string(result.frame) + ",object," +
            CsvField(object.name) + std::string(10, ',') + CsvPose(object.pose) +
            std::string(static_cast<size_t>(columns.inverted + 4 * columns.quality + columns.track),
                        ',') +
            "\n";
  }
  return rows;
}

}  // namespace topotag::tools
