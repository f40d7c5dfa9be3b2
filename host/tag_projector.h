#ifndef TOPOTAG_HOST_TAG_PROJECTOR_H_
#define TOPOTAG_HOST_TAG_PROJECTOR_H_

#include <string>
#include <vector>

#include "topotag/geometry.h"
#include "topotag/renderer.h"

namespace topotag {

/// Maps the tag plane of one marker of a scene (units) to pixels, through pose and lens, and
/// checks that the map is valid there. Refers to the scene. Every Error names the marker.
class TagProjector {
 public:
  /// @throws Error (kInvalidArgument): tag size, grey levels, R or t out of range.
  TagProjector(const Scene& scene, int index);
  /// The same for a marker elsewhere than in the scene: `marker` instead of marker `index`.
  TagProjector(const Scene& scene, const SceneMarker& marker, int index);

  const std::string& name() const { return name_; }

  /// Pixel of a tag point.
  /// @throws Error (kInvalidArgument) where the point is not in front of the camera, or its
  ///         image is not finite.
  Point2 operator()(Point2 tag) const;

  /// Pixel of a tag point of which the frame may show something.
  /// @throws Error (kInvalidArgument), also where the lens model is not one-to-one.
  Point2 Visible(Point2 tag) const;

  /// Image of a polygon in the tag plane: chords that follow the lens to kOutlineTolerance in and
  /// around the frame.
  /// @throws Error (kInvalidArgument) like Visible, for all that the frame may show.
  std::vector<Point2> Outlined(const std::vector<Point2>& tag) const;

  /// Sides of a circle's polygon for kOutlineTolerance.
  int CircleSegments(const Outline& circle) const;

  static constexpr double kOutlineTolerance = 5e-4;  ///< pixels

 private:
  Point2 Normalized(Point2 tag) const;
  void CheckLens(Point2 tag, Point2 pixel) const;
  [[noreturn]] void FailBeyondLens(Point2 tag) const;
  double DistanceToFrame(Point2 pixel) const;
  bool MayShow(Point2 a, Point2 b) const;
  void AppendEdge(Point2 p, Point2 q, Point2 a, Point2 b, int depth,
                  std::vector<Point2>* image) const;
  bool IsStraight(Point2 p, Point2 q, Point2 a, Point2 b) const;

  const Camera& camera_;
  const SceneMarker& marker_;
  std::string name_;
  double unit_;   // metres
  double apron_;  // beyond this distance from the frame (pixels) nothing shows in it
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_TAG_PROJECTOR_H_
