#include "tools/report_formats.h"

namespace topotag::tools {
namespace {

using Json = nlohmann::ordered_json;

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

}  // namespace

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
