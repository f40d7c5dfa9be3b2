#include "tools/scene_conditions.h"

#include <string>

namespace topotag::tools {
namespace {

Shadow ReadShadow(const JsonNode& node) {
  node.AllowOnly({"point", "angle", "factor", "penumbra"});
  Shadow shadow;
  shadow.point = node.Point("point");
  shadow.angle = node.Number("angle", shadow.angle);
  shadow.factor = node.Number("factor", shadow.factor);
  shadow.penumbra = node.Number("penumbra", shadow.penumbra);
  return shadow;
}

Highlight ReadHighlight(const JsonNode& node) {
  node.AllowOnly({"center", "sigma", "level"});
  Highlight highlight;
  highlight.center = node.Point("center");
  highlight.sigma = node.Number("sigma", highlight.sigma);
  highlight.level = node.Number("level", highlight.level);
  return highlight;
}

Lighting ReadLighting(const JsonNode& node) {
  node.AllowOnly({"gain", "gradient", "vignetting", "shadow", "highlights"});
  Lighting lighting;
  lighting.gain = node.Number("gain", lighting.gain);
  if (node.Has("gradient")) lighting.gradient = node.Point("gradient");
  lighting.vignetting = node.Number("vignetting", lighting.vignetting);
  if (node.Has("shadow")) {
    lighting.shadow = ReadShadow(JsonNode(node.Get("shadow"), node.Where("shadow")));
  }
  for (const Json& highlight : node.List("highlights")) {
    const std::string which = "highlight " + std::to_string(lighting.highlights.size());
    lighting.highlights.push_back(ReadHighlight(JsonNode(highlight, node.Where(which.c_str()))));
  }
  return lighting;
}

Occluder ReadOccluder(const JsonNode& node, size_t markers) {
  node.AllowOnly({"outline", "level", "marker"});
  Occluder occluder;
  node.Get("outline");
  for (const Json& point : node.List("outline")) {
    occluder.outline.push_back(JsonNode::ToPoint(point, node.Where("outline")));
  }
  occluder.level = node.Number("level", occluder.level);
  if (!node.Has("marker")) return occluder;
  const uint64_t marker = node.Whole("marker");
  if (marker >= markers) {
    Fail(node.Where("marker"),
         std::to_string(marker) + " is not one of the scene's " + std::to_string(markers));
  }
  occluder.marker = static_cast<int>(marker);
  return occluder;
}

}  // namespace

void ReadConditions(const JsonNode& node, Scene* scene) {
  scene->exposure = node.Number("exposure", scene->exposure);
  scene->row_time = node.Number("row_time", scene->row_time);
  if (node.Has("lighting")) {
    scene->lighting = ReadLighting(JsonNode(node.Get("lighting"), node.Where("lighting")));
  }
  for (const Json& occluder : node.List("occluders")) {
    const std::string which = "occluder " + std::to_string(scene->occluders.size());
    scene->occluders.push_back(
        ReadOccluder(JsonNode(occluder, node.Where(which.c_str())), scene->markers.size()));
  }
}

}  // namespace topotag::tools
