#ifndef TOPOTAG_BENCH_PAPER_WALK_H_
#define TOPOTAG_BENCH_PAPER_WALK_H_

#include <functional>
#include <string>
#include <vector>

#include "bench/paper/context.h"
#include "bench/paper/systems.h"

namespace topotag::bench::paper {

constexpr int kWalkStart = 300;  // millimetres

/// From kWalkStart away from the camera or towards it, until a frame is not read: in each of the
/// steps, on from where the one before came to.
struct Walk {
  std::vector<int> steps;  ///< ever smaller, millimetres; negative towards the camera
  int last = 0;            ///< where it ends in any case, millimetres
  int frames = 0;          ///< at each distance
  std::function<Scene(int millimetres, int frame)> scene;
};

/// Away from the camera, at random within the middle 40 % of the frame's width and height.
/// @param tilt  degrees.
Walk WalkAway(const Context& context, double tilt);

struct WalkEnd {
  int distance = 0;  ///< the last at which all frames were read, millimetres; 0: not even the first
  /// Where something was detected that is not there: "at 300 mm, frame 2".
  std::vector<std::string> wrong;
};

WalkEnd Go(const Walk& walk, System* system);

/// Notes those of ours.
void AddWrong(const std::string& system, const WalkEnd& end, Section* section);

/// The same for all systems.
uint64_t WalkSeed(int millimetres, int frame);

/// "20, then 5, then 1 cm".
std::string StepsOf(const Walk& walk);

/// A distance in a table, metres; "not read" for 0.
Cell WalkCell(int millimetres);

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_WALK_H_
