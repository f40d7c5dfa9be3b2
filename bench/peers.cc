#include "bench/peers.h"

#include <utility>

namespace topotag::bench {

std::vector<std::unique_ptr<Peer>> MakePeers([[maybe_unused]] const PeerSetup& setup) {
  std::vector<std::unique_ptr<Peer>> peers;
#ifdef TOPOTAG_BENCH_WITH_APRILTAG
  AddAprilTag(setup, &peers);
#endif
#ifdef TOPOTAG_BENCH_WITH_ARUCO
  AddAruco(setup, &peers);
#endif
  return peers;
}

std::unique_ptr<Peer> MakeAprilTag([[maybe_unused]] AprilTagFamily family) {
  std::vector<std::unique_ptr<Peer>> peers;
#ifdef TOPOTAG_BENCH_WITH_APRILTAG
  AddAprilTag(family, &peers);
#endif
  return peers.empty() ? nullptr : std::move(peers.front());
}

std::unique_ptr<Peer> MakeAruco([[maybe_unused]] int bits, [[maybe_unused]] bool refine) {
  std::vector<std::unique_ptr<Peer>> peers;
#ifdef TOPOTAG_BENCH_WITH_ARUCO
  AddAruco(bits, refine, &peers);
#endif
  return peers.empty() ? nullptr : std::move(peers.front());
}

std::vector<std::unique_ptr<Peer>> MakeRefinedAruco() {
  std::vector<std::unique_ptr<Peer>> peers;
#ifdef TOPOTAG_BENCH_WITH_ARUCO
  AddRefinedAruco(&peers);
#endif
  return peers;
}

std::vector<std::string> MissingPeers() {
  std::vector<std::string> missing;
#ifndef TOPOTAG_BENCH_WITH_APRILTAG
  missing.push_back("AprilTag 3: built without libapriltag-dev");
#endif
#ifndef TOPOTAG_BENCH_WITH_ARUCO
  missing.push_back("OpenCV ArUco: built without OpenCV's aruco module");
#endif
  return missing;
}

}  // namespace topotag::bench
