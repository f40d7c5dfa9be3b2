#ifndef TOPOTAG_BENCH_PEERS_H_
#define TOPOTAG_BENCH_PEERS_H_

#include <memory>
#include <string>
#include <vector>

#include "bench/bitmap_marker.h"

namespace topotag::bench {

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
  virtual BitmapMarker Marker(int id) const = 0;
  /// IDs of the markers found, in any order; without poses.
  virtual void Detect(const ImageView& image, std::vector<int>* ids) = 0;
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

/// Each library's own; in builds that have it.
void AddAprilTag(const PeerSetup& setup, std::vector<std::unique_ptr<Peer>>* peers);
void AddAruco(const PeerSetup& setup, std::vector<std::unique_ptr<Peer>>* peers);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_PEERS_H_
