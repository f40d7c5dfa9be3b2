#ifndef TOPOTAG_BENCH_PAPER_SYSTEMS_H_
#define TOPOTAG_BENCH_PAPER_SYSTEMS_H_

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/paper/section.h"
#include "topotag/detector.h"
#include "topotag/renderer.h"

namespace topotag::bench::paper {

/// The paper's: 1280 x 960, 98 degrees across the diagonal, which is a focal length of 695 pixels.
Camera PaperCamera();

/// Side of every marker with all of the border that belongs to it, metres.
inline constexpr double kMarkerSide = 0.05;

/// What a system says of one marker.
struct Seen {
  uint64_t id = 0;
  /// Clockwise from the one at the marker's top left: of the white square (ours), of the black one
  /// (peers); pixels.
  std::array<Point2, 4> corners{};
  /// What jitters: ours the vertices, peers the corners.
  std::vector<Point2> points;
  /// One of each of System::solvers(); nothing where that one has found none. Empty after Find.
  std::vector<std::optional<PoseSolution>> poses;
};

/// A kind of marker with the detector that looks for it, and for nothing else.
/// Thread safety: one for each thread.
class System {
 public:
  virtual ~System() = default;
  virtual Who who() const = 0;
  /// For tables: "TopoTag 4x4", "AprilTag 36h11", "ArUco 6x6".
  virtual std::string name() const = 0;
  /// Library, version and parameters.
  virtual std::string description() const = 0;
  /// Number of IDs.
  virtual uint64_t dictionary_size() const = 0;
  /// Ways to a pose, best known first: ours "photometric", "vertices".
  virtual std::vector<std::string> solvers() const = 0;
  /// Side of what carries the marker, without its border, metres: the white area (ours), the black
  /// square (peers).
  virtual double core_side() const = 0;

  /// An ID of the dictionary; the same for the same seed.
  uint64_t IdFor(uint64_t seed) const;

  /// The frame of a scene of one marker with this system's instead, in the same pose and of
  /// kMarkerSide, whatever the size in the scene. Everything else stays as it is: light, noise,
  /// motion, and where occluders are that move with the marker, too.
  virtual Image Render(const Scene& scene, uint64_t id) const = 0;
  /// Where `points` of what this system has seen should be: exact projections. Pixels.
  virtual std::vector<Point2> TruePoints(const Scene& scene) const = 0;

  /// All markers in a frame of PaperCamera, without poses: what the system needs to name them.
  virtual void Find(const ImageView& frame, std::vector<Seen>* markers) = 0;
  /// The same with poses.
  virtual void Locate(const ImageView& frame, std::vector<Seen>* markers) = 0;
  /// All markers with the poses of one of solvers() and nothing else: for measuring time.
  /// @return their number
  virtual int Run(const ImageView& frame, size_t solver) = 0;
};

using Systems = std::vector<std::unique_ptr<System>>;

/// Ours with a design's family and shapes; its ID does not matter.
/// @param options  families, camera, tag size, threads and pose are set here.
std::unique_ptr<System> MakeOurs(const std::string& name, const MarkerDesign& design,
                                 const Options& options);
/// TopoTag 3x3, 4x4, 5x5 with square nodes, as in the paper, Options::far on.
Systems MakeOurs();

/// AprilTag 3 with 36h11, 25h9, 16h5 (quad_decimate 1: its most exact), OpenCV's ArUco with 4x4,
/// 5x5, 6x6 (dictionaries of 250): those that this build has.
Systems MakePeerSystems();
/// ArUco again, with its corners refined by cornerSubPix: "ArUco 4x4 subpix".
Systems MakeRefinedPeerSystems();

/// Ours, then the peers.
Systems MakeSystems();
/// And then the refined ones.
Systems MakeAllSystems();
/// The same for each of so many threads.
std::vector<Systems> MakeSystemsFor(int threads);

/// Frames, and what a system said to them.
struct Tally {
  int frames = 0;
  int found = 0;
  int wrong = 0;  ///< detections of what is not there, or of a marker for the second time

  void Add(const Tally& other);
};

/// One frame. Found: the ID, with its centre within a quarter of the marker's side of the truth.
/// @param truth  of the scene's marker; @param markers  of Find or Locate.
Tally Judge(const Scene& scene, uint64_t id, const std::vector<Seen>& markers);

/// The marker that Judge counts as found, or null.
const Seen* FindMarker(const Scene& scene, uint64_t id, const std::vector<Seen>& markers);

/// A scene of one marker in PaperCamera: blur 0.7 pixels, noise 2, black 25, white 215,
/// background 90; design and size as in bench/views.h: a 4x4 with square nodes, 19 units wide with
/// its frame, in which outlines of occluders with marker = 0 are given.
Scene PaperScene(const Matrix3& R, const Vector3& t, uint64_t seed);

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_SYSTEMS_H_
