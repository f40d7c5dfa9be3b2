#include "bench/paper/walk.h"

#include <cstdlib>

#include "bench/paper/trials.h"
#include "bench/svg.h"

namespace topotag::bench::paper {
namespace {

bool ReadAll(const Walk& walk, int distance, System* system, WalkEnd* end) {
  std::vector<Seen> markers;
  for (int frame = 0; frame < walk.frames; ++frame) {
    const Scene scene = walk.scene(distance, frame);
    const uint64_t id = system->IdFor(scene.seed);
    system->Find(system->Render(scene, id).view(), &markers);
    const Tally tally = Judge(scene, id, markers);
    if (tally.wrong > 0) {
      end->wrong.push_back("at " + std::to_string(distance) + " mm, frame " +
                           std::to_string(frame));
    }
    if (tally.found == 0) return false;
  }
  return true;
}

}  // namespace

Walk WalkAway(const Context& context, double tilt) {
  Walk walk;
  walk.steps = context.quick ? std::vector<int>{1000} : std::vector<int>{200, 50, 10};
  walk.last = 5000;
  walk.frames = context.Frames(6, 1);
  walk.scene = [tilt](int millimetres, int frame) {
    return FreeView(1e-3 * millimetres, tilt, WalkSeed(millimetres, frame));
  };
  return walk;
}

WalkEnd Go(const Walk& walk, System* system) {
  WalkEnd end;
  if (!ReadAll(walk, kWalkStart, system, &end)) return end;
  end.distance = kWalkStart;
  int failed = 0;  // the nearest distance at which a frame was not read
  for (const int step : walk.steps) {
    for (int next = end.distance + step; next != failed && (walk.last - next) * step >= 0;
         next += step) {
      if (!ReadAll(walk, next, system, &end)) {
        failed = next;
        break;
      }
      end.distance = next;
    }
  }
  return end;
}

void AddWrong(const std::string& system, const WalkEnd& end, Section* section) {
  for (const std::string& where : end.wrong) {
    section->broken.push_back(system + ": wrong detection " + where);
  }
}

uint64_t WalkSeed(int millimetres, int frame) {
  return static_cast<uint64_t>(millimetres) * 1000 + static_cast<uint64_t>(frame);
}

std::string StepsOf(const Walk& walk) {
  std::string text;
  for (const int step : walk.steps) {
    text += (text.empty() ? "" : ", then ") + ShortNumber(0.1 * std::abs(step));
  }
  return text + " cm";
}

Cell WalkCell(int millimetres) {
  if (millimetres == 0) return {"not read", std::nullopt};
  return Number(1e-3 * millimetres, 3);
}

}  // namespace topotag::bench::paper
