#ifndef TOPOTAG_BENCH_PAPER_TRIALS_H_
#define TOPOTAG_BENCH_PAPER_TRIALS_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/paper/context.h"
#include "bench/paper/systems.h"

namespace topotag::bench::paper {

/// What a system has said to one frame.
struct Trial {
  Tally tally;
  /// Of the best known way to a pose (System::solvers), where the marker was found.
  std::optional<double> position_mm, rotation_degrees;
};

/// One system on all frames.
struct SystemTrials {
  Who who = Who::kOurs;
  std::string name;
  std::vector<Trial> trials;  ///< one a frame
};

/// The scene of one frame, the same for all systems; its seed also chooses the ID.
using MakeTrialScene = std::function<Scene(int frame)>;

/// Every system with its own marker on every frame.
/// @param make  the systems, once for each thread.
/// @param other_steps  of the progress, that the section takes beside these.
std::vector<SystemTrials> RunTrials(const Context& context, const std::function<Systems()>& make,
                                    int frames, const MakeTrialScene& scene, int other_steps = 0);

/// For Section::broken: the frames in which ours detected what is not there.
std::vector<std::string> WrongDetections(const std::vector<SystemTrials>& systems);

/// Consecutive frames of one system.
struct TrialSummary {
  Tally tally;
  /// Median and largest of the frames in which the marker was found; nothing where none was.
  std::optional<double> position_mm, max_position_mm, rotation_degrees, max_rotation_degrees;
};
TrialSummary Summarize(const SystemTrials& system, int first, int count);

/// Frames 0 .. count * titles.size() - 1, of each condition `count`, as tables with a row for each
/// system: one of the share found of each condition, with what was detected that is not there over
/// all of them, and one of the medians of the position's and the rotation's errors, where at least
/// half of the markers were found.
std::vector<Table> ConditionTables(const std::string& id, const std::string& title,
                                   const std::vector<std::string>& titles,
                                   const std::vector<SystemTrials>& systems, int first, int count);

/// The same figures for the JSON: {"TITLE": {"SYSTEM": {"frames", "found", "wrong",
/// "position_mm", "rotation_degrees"}}}.
Json ConditionData(const std::vector<std::string>& titles, const std::vector<SystemTrials>& systems,
                   int first, int count);

/// A square part of a frame around the marker, its border and a margin included; pixels are
/// repeated where it would be small.
Picture PictureOf(const std::string& caption, const Scene& scene, const System& system);

/// "1 frame", "12 frames".
std::string FramesText(int count);

/// A marker in a view of bench/views.h: turn, tilt's direction and place are random.
Scene FreeView(double distance, double tilt, uint64_t seed);

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_TRIALS_H_
