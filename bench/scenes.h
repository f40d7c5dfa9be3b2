#ifndef TOPOTAG_BENCH_SCENES_H_
#define TOPOTAG_BENCH_SCENES_H_

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "bench/photos.h"
#include "topotag/options.h"
#include "topotag/renderer.h"

namespace topotag::bench {

enum class SceneKind {
  kOneMarker,  ///< on a noisy wall
  kMarkers,    ///< 20 on a noisy wall
  kPhoto,      ///< 20 on one photograph
  kMosaic,     ///< 20 on many photographs side by side
  kNoise,      ///< random bytes, no marker
};

inline constexpr std::array<SceneKind, 5> kSceneKinds{SceneKind::kOneMarker, SceneKind::kMarkers,
                                                      SceneKind::kPhoto, SceneKind::kMosaic,
                                                      SceneKind::kNoise};

/// For names of benchmarks: "20_markers".
const char* Name(SceneKind kind);
/// For readers: "20 markers on a wall".
const char* Title(SceneKind kind);

struct FrameSize {
  int width = 0;
  int height = 0;
};

inline constexpr std::array<FrameSize, 4> kFrameSizes{
    {{640, 480}, {1280, 960}, {1920, 1080}, {3840, 2160}}};

/// "1280x960"
std::string Name(FrameSize size);

/// Poses in front of a background, to be filled with the markers of any system.
struct BenchScene {
  Scene scene;          ///< with our markers; refers to `backdrop` where there is one
  Image backdrop;       ///< without markers and noise, of the frame's size; empty = plain wall
  double min_side = 0;  ///< below that of any marker, with its black frame, pixels
  bool random = false;  ///< random bytes instead of all this
};

/// Side of our marker with its black frame, metres: that of every other marker in its place.
double OuterSide(const SceneMarker& marker);

/// A camera of 695 pixels focal length at 1280 wide, and in proportion at other sizes; markers of
/// 4x4, 5 cm, at 0.4 m, tilted by up to 40 degrees to the line of sight; noise of 2 grey levels,
/// blur of 0.7 pixels.
BenchScene MakeScene(SceneKind kind, FrameSize size, const Photos& photos);

/// `count` markers, at most 208, at 0.8 m on a noisy wall of 1280 x 960; those of a smaller count
/// are among those of a larger one.
BenchScene MakeCrowd(int count);

/// Turns the optical axis into the line of sight to a point.
Matrix3 LineOfSight(const Vector3& t);

/// The frame with our markers.
Image RenderTopoTags(const BenchScene& scene);

/// Camera and tag size of the scene: poses are part of the work. One thread.
Options SceneOptions(const BenchScene& scene);

/// Enough copies of a frame to exceed the caches: with these in rotation each comes from memory.
class ColdFrames {
 public:
  /// @param bytes  of all copies together, at least.
  ColdFrames(const ImageView& frame, size_t bytes);
  const std::vector<ImageView>& views() const { return views_; }

 private:
  std::vector<Image> copies_;
  std::vector<ImageView> views_;
};

/// 64 MiB, or a quarter more than the largest cache, but at most 512 MiB.
size_t ColdBytes();

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_SCENES_H_
