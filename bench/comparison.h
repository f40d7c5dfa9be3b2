#ifndef TOPOTAG_BENCH_COMPARISON_H_
#define TOPOTAG_BENCH_COMPARISON_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/peers.h"
#include "bench/timing.h"

namespace topotag::bench {

/// One system on its own frame of a scene.
struct Contestant {
  std::string name;
  std::string kind;  ///< of ours: scalar, simd, opencl; else the name
  bool ours = false;
  int threads = 1;
  size_t expected = 0;     ///< markers in the frame
  size_t found = 0;        ///< right ones, in the worst round
  size_t wrong = 0;        ///< that are not there, in the worst round
  std::vector<double> us;  ///< wall clock of whole detections

  bool perfect() const { return found == expected && wrong == 0; }
};

/// Whole detections of one scene by ours and by the peers, each with its own markers in the same
/// poses on the same background, in one process and in turn. Ours include the poses of the
/// markers, the peers' do not.
class Comparison {
 public:
  /// @param threads  of the peers.
  Comparison(const BenchScene& scene, const std::vector<Setup>& setups, int threads);
  Comparison(const Comparison&) = delete;
  Comparison& operator=(const Comparison&) = delete;

  /// Every system in turn: one frame to warm up, which counts only where it takes so long that
  /// this makes no difference (50 ms), else up to 10 that count, within 20 ms or one.
  void Round();
  /// Rounds until the seconds have passed, within these numbers.
  void Run(double seconds, int min_rounds, int max_rounds);

  /// Ours in the order of the setups, then the peers.
  const std::vector<Contestant>& contestants() const { return contestants_; }

 private:
  /// The IDs found in the frame.
  using DetectIds = std::function<void(std::vector<int>*)>;

  void AddOurs(const BenchScene& scene, const std::vector<Setup>& setups);
  void AddPeers(const BenchScene& scene, int threads);
  /// @param ids  those in the frame.
  void Add(Contestant contestant, std::vector<int> ids, DetectIds detect);
  void Check(size_t contestant);

  std::vector<Contestant> contestants_;
  std::vector<std::vector<int>> expected_;  ///< sorted IDs of each contestant
  std::vector<DetectIds> detect_;
  std::vector<int> ids_;
};

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_COMPARISON_H_
