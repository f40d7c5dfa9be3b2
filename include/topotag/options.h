#ifndef TOPOTAG_OPTIONS_H_
#define TOPOTAG_OPTIONS_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "topotag/camera.h"
#include "topotag/family.h"
#include "topotag/geometry.h"

namespace topotag {

enum class BackendKind { kAuto, kScalar, kSimd, kOpenCl };
enum class Preset {
  kDefault,  ///< what detects best
  kPaper,    ///< the parameters of the paper (section 4)
};

enum class PoseMode {
  kVertices,     ///< from the vertices
  kPhotometric,  ///< then by aligning the model of the marker with the image, which is slower
};

/// "auto", "scalar", "simd", "opencl".
/// @throws Error (kInvalidArgument) that lists the names.
BackendKind ParseBackend(const std::string& name);
const char* Name(BackendKind backend);
/// "default", "paper".
Preset ParsePreset(const std::string& name);
/// "vertices", "photometric".
PoseMode ParsePoseMode(const std::string& name);
const char* Name(PoseMode mode);

/// What is fastest for one frame: 2, or 1 on a machine with one processor.
int DefaultThreads();
inline constexpr int kMaxThreads = 256;

struct Options {
  std::vector<Family> families{Family(3), Family(4), Family(5)};
  Preset preset = Preset::kDefault;

  /// kAuto takes the environment variable TOPOTAG_BACKEND where it is set, else simd. A backend
  /// that is not available is an error, never replaced.
  BackendKind backend = BackendKind::kAuto;
  /// Of one frame, 1 .. kMaxThreads, the caller's included; results do not depend on it, unless the
  /// caller's rounding mode is another one than when the detector was made. For many frames at a
  /// time: one detector with one thread on each processor.
  int threads = DefaultThreads();

  /// The device of the opencl backend: DeviceInfo::index. Without it: the first GPU, else the first
  /// device. Other backends take no notice.
  std::optional<int> device;

  /// Lens and intrinsics. Without it there is no pose.
  std::optional<Camera> camera;
  /// Side of the white area in metres: of one (family n, ID), else of one family n, else
  /// tag_size. 0 = unknown: no pose. Others: 1e-9 .. 1e6.
  double tag_size = 0;
  std::map<int, double> family_tag_size;
  std::map<std::pair<int, uint64_t>, double> id_tag_size;
  PoseMode pose = PoseMode::kVertices;

  /// The IDs in use of families n: markers of such a family with other IDs are not reported, and
  /// one of which only a part is seen gets the only ID in use that fits, where there is just one.
  /// Families that are not named: all IDs.
  std::map<int, std::vector<uint64_t>> ids;
  /// Smooths each frame with a 5 x 5 filter first, for severe noise (sigma from 10 grey levels on);
  /// everything that follows, vertices included, sees the smoothed frame. Not for frames that are
  /// on an OpenCL device already.
  bool pre_blur = false;
  /// Markers with white and black exchanged are looked for as well, in the complement of each
  /// frame, which costs as much again; Detection::inverted says which they are.
  bool inverted = false;
  /// Markers of which the side of the white area, the mean of the four in Detection::corners, is
  /// shorter than this are not reported, and what is surely smaller is not looked at: 0 .. 1e6
  /// pixels.
  double min_size = 0;
  /// A marker is reported where up to so many of its nodes are hidden, 0 .. kMaxVertices;
  /// Detection::unknown_bits says which.
  int hidden_nodes = 0;

  /// Markers whose holes and gaps the thresholds do not resolve are looked for as well, by matched
  /// filters on the grey levels (docs/design.md). The preset `paper` takes no notice.
  bool far = false;

  /// Only this part of each frame is searched; results stay in full-frame coordinates.
  std::optional<Rect> roi;
};

/// Side of the white area of a marker, metres; 0 = unknown.
double TagSize(const Options& options, Family family, uint64_t id);

}  // namespace topotag

#endif  // TOPOTAG_OPTIONS_H_
