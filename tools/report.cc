#include "tools/report.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "host/mean_side.h"

namespace topotag::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegrees = 180 / 3.14159265358979323846;

/// Adding 0 turns -0 into 0.
double RoundTo(double value, double scale) { return std::round(value * scale) / scale + 0.0; }

double Pixels(double value) { return RoundTo(value, 1e6); }

double Significant(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", value);
  return std::strtod(text, nullptr) + 0.0;
}

Json PointJson(const Point2& point) { return Json::array({Pixels(point.x), Pixels(point.y)}); }

template <typename Points>
Json PointsJson(const Points& points) {
  Json json = Json::array();
  for (const Point2& point : points) json.push_back(PointJson(point));
  return json;
}

template <typename Values>
Json ValuesJson(const Values& values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(Significant(value));
  return json;
}

template <typename Matrix>
Json MatrixJson(const Matrix& matrix) {
  Json json = Json::array();
  for (const auto& row : matrix) json.push_back(ValuesJson(row));
  return json;
}

Json SolutionJson(const PoseSolution& pose) {
  Json json = TransformJson(pose);
  json["rms_px"] = Significant(pose.rms_px);
  return json;
}

Json PhotometricJson(const Photometric& found) {
  Json json;
  json["accepted"] = found.accepted;
  json["sigma"] = Significant(found.sigma);
  json["noise"] = Significant(found.noise);
  json["blur_px"] = Significant(found.blur_px);
  json["black"] = Significant(found.black);
  json["white"] = Significant(found.white);
  json["growth"] = Significant(found.growth);
  json["pixels"] = found.pixels;
  return json;
}

Json PoseJson(const std::optional<Pose>& pose) {
  if (!pose) return nullptr;
  Json json = SolutionJson(*pose);
  json["covariance"] = MatrixJson(pose->covariance);
  json["alternative"] = pose->alternative ? SolutionJson(*pose->alternative) : Json(nullptr);
  if (pose->photometric) {
    json["ambiguity"] = Significant(pose->ambiguity);
    json["photometric"] = PhotometricJson(*pose->photometric);
  }
  return json;
}

Json NamesJson(const std::vector<int>& indices, const std::vector<Detection>& detections) {
  Json json = Json::array();
  for (const int index : indices) {
    const Detection& detection = detections[static_cast<size_t>(index)];
    Json marker;
    marker["family"] = detection.family.name();
    marker["id"] = detection.id;
    json.push_back(std::move(marker));
  }
  return json;
}

Json ObjectsJson(const FrameResult& result) {
  Json json = Json::array();
  for (const FoundObject& object : *result.objects) {
    Json one;
    one["name"] = object.name;
    one.update(PoseJson(object.pose));
    one["markers"] = NamesJson(object.pose.used, result.detections);
    one["rejected"] = NamesJson(object.pose.rejected, result.detections);
    json.push_back(std::move(one));
  }
  return json;
}

Json TimesJson(const StageTimes& times) {
  const auto tenths = [](double time) { return RoundTo(time, 10); };
  Json json;
  json["threshold"] = tenths(times.threshold);
  json["binarize"] = tenths(times.binarize);
  json["label"] = tenths(times.label);
  json["tree"] = tenths(times.tree);
  json["decode"] = tenths(times.decode);
  json["vertices"] = tenths(times.vertices);
  json["pose"] = tenths(times.pose);
  json["total"] = tenths(times.total);
  return json;
}

Json QualityJson(const Quality& quality) {
  Json json;
  json["contrast"] = Significant(quality.contrast);
  json["decision"] = Significant(quality.decision);
  json["sharpness"] = Significant(quality.sharpness);
  json["rms_px"] = Significant(quality.rms_px);
  return json;
}

Json TrackJson(const TrackState& track) {
  Json json;
  json["number"] = track.number;
  json["age"] = track.age;
  json["missed"] = track.missed;
  json["in_region"] = track.in_region;
  return json;
}

std::string FormatJson(const ExtraColumns& columns, const FrameResult& result) {
  Json json = FrameJson(result.image, result.frame, result.width, result.height);
  json["backend"] = result.backend;
  json["detections"] = Json::array();
  for (size_t i = 0; i < result.detections.size(); ++i) {
    const Detection& detection = result.detections[i];
    Json marker = MarkerJson(detection);
    if (detection.margin) marker["margin"] = Significant(*detection.margin);
    if (columns.quality) marker["quality"] = QualityJson(detection.quality);
    if (columns.track) marker["track"] = TrackJson(result.tracks[i]);
    marker["pose"] = PoseJson(detection.pose);
    json["detections"].push_back(std::move(marker));
  }
  if (result.objects) json["objects"] = ObjectsJson(result);
  json["time_us"] = TimesJson(result.times);
  return Dump(json) + "\n";
}

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string CsvNumber(double value) { return Json(value).dump(); }

/// 13 fields, each after a comma.
/// The ID, or where it is not known its code with a ? for each bit that is hidden.
std::string IdText(const Detection& detection) {
  if (detection.unknown_bits == 0) return std::to_string(detection.id);
  std::string code;
  for (int bit = detection.family.bits() - 1; bit >= 0; --bit) {
    code += (detection.unknown_bits >> bit & 1) != 0 ? '?'
            : (detection.id >> bit & 1) != 0         ? '1'
                                                     : '0';
  }
  return code;
}

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

std::string FormatText(const ExtraColumns& columns, const FrameResult& result) {
  const size_t count = result.detections.size();
  char line[256];
  std::string text = result.image;
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
    text += "  object " + object.name;
    std::snprintf(line, sizeof line,
                  "  t (%.4f, %.4f, %.4f) m  rms %.3f px  from %zu of its markers", pose.t[0],
                  pose.t[1], pose.t[2], pose.rms_px, pose.used.size());
    text += line;
    if (!pose.rejected.empty()) text += ", " + std::to_string(pose.rejected.size()) + " rejected";
    text += "\n";
  }
  return text;
}

}  // namespace

std::string FormatHeader(Format format, const ExtraColumns& columns) {
  if (format != Format::kCsv) return "";
  std::string header =
      "image,frame,family,id,center_x,center_y,corner0_x,corner0_y,corner1_x,corner1_y,"
      "corner2_x,corner2_y,corner3_x,corner3_y,tx,ty,tz,r00,r01,r02,r10,r11,r12,r20,r21,r22,"
      "rms_px";
  if (columns.inverted) header += ",inverted";
  if (columns.quality) header += ",contrast,decision,sharpness,fit_px";
  if (columns.track) header += ",track";
  return header + "\n";
}

std::string FormatFrame(Format format, const ExtraColumns& columns, const FrameResult& result) {
  switch (format) {
    case Format::kJson:
      return FormatJson(columns, result);
    case Format::kCsv:
      return FormatCsv(columns, result);
    default:
      return FormatText(columns, result);
  }
}

Json FrameJson(const std::string& image, int64_t frame, int width, int height) {
  Json json;
  json["image"] = image;
  json["frame"] = frame;
  json["width"] = width;
  json["height"] = height;
  return json;
}

Json MarkerJson(const Detection& detection) {
  Json json;
  json["family"] = detection.family.name();
  json["id"] = detection.id;
  if (detection.unknown_bits != 0) json["unknown_bits"] = detection.unknown_bits;
  if (detection.inverted) json["inverted"] = true;
  json["center"] = PointJson(detection.center);
  json["corners"] = PointsJson(detection.corners);
  json["vertices"] = PointsJson(detection.vertices);
  return json;
}

Json TransformJson(const PoseSolution& pose) {
  Json json;
  json["R"] = MatrixJson(pose.R);
  json["t"] = ValuesJson(pose.t);
  return json;
}

std::string Dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace topotag::tools
