#ifndef TOPOTAG_OBJECT_H_
#define TOPOTAG_OBJECT_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "topotag/camera.h"
#include "topotag/detection.h"
#include "topotag/family.h"
#include "topotag/geometry.h"

namespace topotag {

/// A marker of an object: x_object = R x_tag + t, metres. The tag's z axis points into the tag,
/// away from the viewer.
struct ObjectMarker {
  Family family{4};
  uint64_t id = 0;
  double tag_size = 0.05;  ///< side of the white area, metres, 1e-9 .. 1e6
  Matrix3 R{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Vector3 t{};
};

/// A rigid body with markers on it: a board, a polyhedron, a room. In its own frame, metres.
struct Object {
  std::string name;
  std::vector<ObjectMarker> markers;
};

/// @throws Error (kInvalidArgument): no marker; an ID out of the family's range, one that occurs
///         twice, a size that is not within 1e-9 .. 1e6, a pose that is not finite, R that is no
///         rotation. The message names the marker.
void ValidateObject(const Object& object);

/// A board of rows x columns upright markers with IDs from first_id, row by row. Origin at its
/// centre, x right, y down, z into the board.
/// @param pitch  distance of neighbouring centres, metres, at least tag_size
/// @throws Error (kInvalidArgument) that names the value.
Object MakeGrid(Family family, uint64_t first_id, int rows, int columns, double tag_size,
                double pitch);

/// The 18 square faces of a rhombicuboctahedron around the origin, a marker centred on each. In
/// order: the belt of 8 faces about the y axis, each 45 degrees further (the first, with R =
/// identity, looks along -z, the third along +x), the 4 faces that look up (-y) and outwards, the
/// first one above the belt's first, the 4 that look down, the top, the bottom.
/// @param edge  of the body, metres, at least tag_size
/// @throws Error (kInvalidArgument) that names the value.
Object MakeRhombicuboctahedron(Family family, uint64_t first_id, double tag_size, double edge);

/// Reads an object, a marker a line: FAMILY ID SIZE TX TY TZ RX RY RZ, lengths in metres, the
/// rotation as axis times angle in radians, at most one turn. Blank lines and # comments are
/// ignored. The object's name is that of the file without its extension.
/// @throws Error (kFile, kParse) that names the file, the line and what is wrong there.
Object ReadObject(const std::string& path);

/// Writes what ReadObject reads, to 1e-12. A failure leaves the old file or none, never a part of
/// one.
/// @throws Error (kFile; kInvalidArgument as ValidateObject).
void WriteObject(const Object& object, const std::string& path);

/// Pose of an object: x_camera = R x_object + t, with rms_px over the vertices of `used`.
struct ObjectPose : Pose {
  std::vector<int> used;      ///< indices of the detections that it rests on, ascending
  std::vector<int> rejected;  ///< of those with an ID of the object that contradict it, ascending
};

/// Finds the pose of one object in each frame, from the vertices of all its visible markers. Those
/// that were refined photometrically, read from afar or partly hidden count by their poses instead,
/// which therefore need the right tag size (Options::id_tag_size).
///
/// Each marker's own poses, both of the planar problem, are tried as the object's; the one that
/// most markers agree with is refined by Levenberg-Marquardt on the reprojection error of all
/// vertices, and markers that contradict the others (misread, moved, or a second one with the same
/// ID) are left out.
/// Thread safety: one estimator per thread; as for Detector, builds without NDEBUG notice. One that
/// was moved from can be destroyed and assigned to; all else throws Error (kInvalidArgument).
class ObjectPoseEstimator {
 public:
  /// @throws Error (kInvalidArgument) as ValidateObject and ValidateCamera.
  ObjectPoseEstimator(const Object& object, const Camera& camera);
  ~ObjectPoseEstimator();
  ObjectPoseEstimator(ObjectPoseEstimator&&) noexcept;
  ObjectPoseEstimator& operator=(ObjectPoseEstimator&&) noexcept;

  /// @param detections  of one frame, in any order; their poses are not needed
  /// @return false, *pose untouched, where no marker of the object gives a pose.
  /// @throws Error (kInvalidArgument) where pose is null
  bool estimate(const std::vector<Detection>& detections, ObjectPose* pose);

  const Object& object() const;

 private:
  struct Impl;
  Impl& impl() const;

  std::unique_ptr<Impl> impl_;
};

}  // namespace topotag

#endif  // TOPOTAG_OBJECT_H_
