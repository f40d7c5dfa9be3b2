#ifndef TOPOTAG_BENCH_PEERS_H_
#define TOPOTAG_BENCH_PEERS_H_

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/bitmap_marker.h"

namespace topotag::bench {

/// Where a peer has seen a marker.
struct Located {
  int id = 0;
  /// Of the black square, clockwise from the one at the bitmap's top left; pixels, (0, 0) =
  /// centre of the top-left pixel.
  std::array<Point2, 4> corners;
};

/// A detector of other markers, with the parameters that its users get unless they change them.
class Peer {
 public:
  virtual ~Peer() = default;
  /// For tables: "AprilTag d2".
  virtual std::string name() const = 0;
  /// Library, version and parameters.
  virtual std::string description() const = 0;
  /// The same for peers that look for the same markers.
  virtual std::string dictionary() const = 0;
  /// Number of IDs.
  virtual int dictionary_size() const = 0;
  virtual BitmapMarker Marker(int id) const = 0;
  /// IDs of the markers found, in any order; without poses.
  virtual void Detect(const ImageView& image, std::vector<int>* ids) = 0;
  /// The same with the corners.
  virtual void Locate(const ImageView& image, std::vector<Located>* markers) = 0;
  /// The pose of marker `index` of the last Locate by the library's own function, if it has one.
  /// @param side  of the black square, metres.
  virtual std::optional<PoseSolution> OwnPose(size_t /*index*/, const Camera& /*camera*/,
                                              double /*side*/) {
    return std::nullopt;
  }
  /// Side of the black square as a share of the whole marker's.
  virtual double black_share() const = 0;
};

/// What the peers are told.
struct PeerSetup {
  int threads = 1;
  double min_side = 50;      ///< of the smallest marker, white border included, pixels
  double frame_side = 1280;  ///< of the frame, the longer one, pixels
};

/// AprilTag 3 with quad_decimate 1 and 2, OpenCV's ArUco by default and as ArUco3: those that this
/// build has.
std::vector<std::unique_ptr<Peer>> MakePeers(const PeerSetup& setup);

/// "AprilTag 3: the reason", of those that this build does not have.
std::vector<std::string> MissingPeers();

enum class AprilTagFamily { k16h5, k25h9, k36h11 };

/// AprilTag 3 with quad_decimate 1; null in a build without it.
std::unique_ptr<Peer> MakeAprilTag(AprilTagFamily family = AprilTagFamily::k36h11);
/// OpenCV's ArUco with the dictionary of 250 markers of bits x bits, 4 to 6, and default parameters
/// but for its corners, refined by cornerSubPix on demand; null in a build without it.
std::unique_ptr<Peer> MakeAruco(int bits, bool refine);
/// OpenCV's ArUco with its corners refined as by cornerSubPix and as by AprilTag 2; none in a build
/// without it.
std::vector<std::unique_ptr<Peer>> MakeRefinedAruco();

/// Each library's own; in builds that have it.
void AddAprilTag(const PeerSetup& setup, std::vector<std::unique_ptr<Peer>>* peers);
void AddAprilTag(AprilTagFamily family, std::vector<std::unique_ptr<Peer>>* peers);
void AddAruco(const PeerSetup& setup, std::vector<std::unique_ptr<Peer>>* peers);
void AddAruco(int bits, bool refine, std::vector<std::unique_ptr<Peer>>* peers);
void AddRefinedAruco(std::vector<std::unique_ptr<Peer>>* peers);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_PEERS_H_
