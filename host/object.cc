#include "topotag/object.h"

#include <cmath>
#include <set>
#include <utility>

#include "host/check.h"
#include "host/object_name.h"
#include "host/rigid_transform.h"
#include "host/tag_size.h"

namespace topotag {
namespace {

constexpr double kMaxLength = 1e6;  // metres
constexpr int kMaxSide = 1000;      // markers along a side of a board

constexpr int kBelt = 8;
constexpr int kRing = 4;

// IDs first_id .. first_id + count - 1 must exist.
void CheckIds(Family family, uint64_t first_id, uint64_t count) {
  if (first_id < family.size() && count <= family.size() - first_id) return;
  FailArgument(std::to_string(count) + " IDs from " + std::to_string(first_id) +
               " leave the range 0 .. " + std::to_string(family.size() - 1) + " of " +
               family.name());
}

void CheckSides(double tag_size, const char* name, double length) {
  RequireRange("tag size", tag_size, kMinTagSize, kMaxTagSize, "m");
  RequireRange(name, length, tag_size, kMaxLength, "m");
}

// Rotation by a multiple of 45 degrees, exact where it is one of 90. `cycle` is the axis that
// follows the axis of rotation: 1 turns about x, 2 about y.
Matrix3 EighthTurns(int eighths, size_t cycle) {
  const double half = std::sqrt(0.5);
  const std::array<double, kBelt> cosines{1, half, 0, -half, -1, -half, 0, half};
  const double c = cosines[static_cast<size_t>(eighths & 7)];
  const double s = cosines[static_cast<size_t>((eighths - 2) & 7)];
  const size_t next = (cycle + 1) % 3;
  Matrix3 m = kIdentity3;
  m[cycle][cycle] = m[next][next] = c;
  m[cycle][next] = -s;
  m[next][cycle] = s;
  return m;
}

}  // namespace

std::string FaultOf(const ObjectMarker& marker) {
  if (marker.id >= marker.family.size()) {
    return "the ID is outside the range 0 .. " + std::to_string(marker.family.size() - 1) + " of " +
           marker.family.name();
  }
  if (!(marker.tag_size >= kMinTagSize && marker.tag_size <= kMaxTagSize)) {
    return "the size " + Text(marker.tag_size) + " m is not within " + Text(kMinTagSize) + " .. " +
           Text(kMaxTagSize);
  }
  for (const double value : marker.t) {
    if (!(std::abs(value) <= kMaxLength)) {
      return "the position " + Text(value) + " m is not within " + Text(-kMaxLength) + " .. " +
             Text(kMaxLength);
    }
  }
  return IsRotation(marker.R) ? "" : "R is not a rotation matrix";
}

void ValidateObject(const Object& object) {
  if (object.markers.empty()) FailArgument("the object has no marker");
  std::set<std::pair<int, uint64_t>> seen;
  for (const ObjectMarker& marker : object.markers) {
    const std::string name = MarkerName(marker.family, marker.id);
    const std::string fault = FaultOf(marker);
    if (!fault.empty()) FailArgument(name + ": " + fault);
    if (!seen.insert({marker.family.n(), marker.id}).second) FailArgument(name + " occurs twice");
  }
}

Object MakeGrid(Family family, uint64_t first_id, int rows, int columns, double tag_size,
                double pitch) {
  RequireRange("number of rows", rows, 1, kMaxSide);
  RequireRange("number of columns", columns, 1, kMaxSide);
  CheckSides(tag_size, "pitch", pitch);
  CheckIds(family, first_id, static_cast<uint64_t>(rows) * static_cast<uint64_t>(columns));
  Object board;
  board.name = "board";
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      ObjectMarker marker;
      marker.family = family;
      marker.id = first_id + board.markers.size();
      marker.tag_size = tag_size;
      marker.t = {(c - (columns - 1) / 2.0) * pitch, (r - (rows - 1) / 2.0) * pitch, 0};
      board.markers.push_back(marker);
    }
  }
  return board;
}

Object MakeRhombicuboctahedron(Family family, uint64_t first_id, double tag_size, double edge) {
  constexpr uint64_t kFaces = kBelt + 2 * kRing + 2;
  CheckSides(tag_size, "edge", edge);
  CheckIds(family, first_id, kFaces);
  const double distance = edge * (1 + std::sqrt(2.0)) / 2;
  Object body;
  body.name = "rhombicuboctahedron";
  // The first face, pitched about x and then turned about y. A positive turn about y takes -z,
  // where the first face looks, to -x.
  const auto add = [&](int turn, int pitch) {
    ObjectMarker marker;
    marker.family = family;
    marker.id = first_id + body.markers.size();
    marker.tag_size = tag_size;
    marker.R = EighthTurns(-turn, 2) * EighthTurns(pitch, 1);
    marker.t = marker.R * Vector3{0, 0, -distance};
    body.markers.push_back(marker);
  };
  for (int i = 0; i < kBelt; ++i) add(i, 0);
  for (int i = 0; i < kRing; ++i) add(2 * i, -1);
  for (int i = 0; i < kRing; ++i) add(2 * i, 1);
  add(0, -2);
  add(0, 2);
  return body;
}

}  // namespace topotag
