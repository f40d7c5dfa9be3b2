#include "tools/object_finder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tools/command.h"
#include "tools/draw.h"

namespace topotag::tools {
namespace {

/// Greatest distance of a marker's centre from the object's origin plus half its side, metres.
double Reach(const Object& object) {
  double reach = 0;
  for (const ObjectMarker& marker : object.markers) {
    reach =
        std::max(reach, std::hypot(marker.t[0], marker.t[1], marker.t[2]) + marker.tag_size / 2);
  }
  return reach;
}

}  // namespace

void SetObjectOptions(const Object& object, Options* options) {
  std::vector<Family>& families = options->families;
  for (const ObjectMarker& marker : object.markers) {
    options->id_tag_size[{marker.family.n(), marker.id}] = marker.tag_size;
    if (std::find(families.begin(), families.end(), marker.family) == families.end()) {
      families.push_back(marker.family);
    }
  }
}

ObjectFinder::ObjectFinder(const std::vector<std::string>& files) {
  std::map<std::string, std::string> names;
  std::map<std::pair<int, uint64_t>, std::string> markers;
  for (const std::string& file : files) {
    Object object = ForOption("--object", [&] { return ReadObject(file); });
    const auto [same, is_new] = names.insert({object.name, file});
    if (!is_new) {
      throw UsageError("--object: " + file + " and " + same->second + " have the same name");
    }
    for (const ObjectMarker& marker : object.markers) {
      const auto [other, is_free] = markers.insert({{marker.family.n(), marker.id}, file});
      if (!is_free) {
        throw UsageError("--object: marker " + marker.family.name() + " " +
                         std::to_string(marker.id) + " is in " + other->second + " and in " + file);
      }
    }
    objects_.push_back(std::move(object));
  }
}

void ObjectFinder::SetOptions(bool choose, Options* options) const {
  for (const Object& object : objects_) {
    const std::vector<Family> asked = options->families;
    SetObjectOptions(object, options);
    if (choose || options->families.size() == asked.size()) continue;
    throw UsageError("--family: " + options->families.back().name() + " is missing, which " +
                     object.name + " has");
  }
}

void ObjectFinder::SetCamera(const Camera& camera) {
  estimators_.clear();
  for (const Object& object : objects_) estimators_.emplace_back(object, camera);
}

void ObjectFinder::Find(const std::vector<Detection>& detections, std::vector<FoundObject>* found) {
  found->clear();
  for (ObjectPoseEstimator& estimator : estimators_) {
    FoundObject one;
    if (!estimator.estimate(detections, &one.pose)) continue;
    one.name = estimator.object().name;
    found->push_back(std::move(one));
  }
}

void ObjectFinder::Draw(const std::vector<FoundObject>& found, const Camera& camera,
                        cv::Mat* picture) const {
  for (const FoundObject& one : found) {
    const auto object = std::find_if(objects_.begin(), objects_.end(),
                                     [&](const Object& o) { return o.name == one.name; });
    DrawPoseAxes(picture, one.pose, camera, Reach(*object));
  }
}

}  // namespace topotag::tools
