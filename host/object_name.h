#ifndef TOPOTAG_HOST_OBJECT_NAME_H_
#define TOPOTAG_HOST_OBJECT_NAME_H_

#include <string>

#include "topotag/object.h"

namespace topotag {

/// How messages name a marker: "marker 4x4 12".
inline std::string MarkerName(Family family, uint64_t id) {
  return "marker " + family.name() + " " + std::to_string(id);
}

/// What is wrong with one marker, whatever the others are; empty where nothing is.
std::string FaultOf(const ObjectMarker& marker);

}  // namespace topotag

#endif  // TOPOTAG_HOST_OBJECT_NAME_H_
