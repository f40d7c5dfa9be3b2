#ifndef TOPOTAG_BENCH_PAPER_TRAJECTORIES_H_
#define TOPOTAG_BENCH_PAPER_TRAJECTORIES_H_

#include <string>
#include <vector>

#include "bench/photos.h"
#include "topotag/renderer.h"

namespace topotag::bench::paper {

/// Frames of one marker that moves, or rests: scenes for System::Render.
struct Trajectory {
  std::string name;         ///< "Seq #1"
  std::string description;  ///< for the page
  std::vector<Scene> scenes;
};

/// The three sequences with so many frames each. The paper moved printed markers with a robot arm;
/// these paths are in its spirit: distances, in-plane and out-of-plane rotation, blur and
/// backgrounds. The scenes refer to the photographs.
std::vector<Trajectory> MakeSequences(int frames, const Photos& photos);

/// A place at which the marker rests.
struct Position {
  std::string name;  ///< "0.2 m, 30°"
  Scene scene;       ///< the first frame; only the seed of its noise changes
};

/// Ten of them, or so many: distances of 0.2 to 0.6 m, tilts of 0, 30, 60 and 75 degrees.
std::vector<Position> MakePositions(int count);
inline constexpr int kPositions = 10;

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_TRAJECTORIES_H_
