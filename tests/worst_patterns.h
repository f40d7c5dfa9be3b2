#ifndef TOPOTAG_TESTS_WORST_PATTERNS_H_
#define TOPOTAG_TESTS_WORST_PATTERNS_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "tests/marker_canvas.h"
#include "tests/random_image.h"

namespace topotag {

/// A picture that is meant to cost as much as it can: the most runs, components, unions or
/// candidates.
struct Pattern {
  std::string name;
  std::function<bool(int x, int y)> white;
};

namespace pattern_internal {

inline std::function<bool(int, int)> Cells(int width, int height, int percent, uint64_t seed) {
  Random random(seed);
  std::vector<bool> cells(static_cast<size_t>(width) * static_cast<size_t>(height));
  for (size_t i = 0; i < cells.size(); ++i) cells[i] = random.Chance(percent);
  return [=](int x, int y) { return cells[static_cast<size_t>(y * width + x)]; };
}

/// Markers of n x n side by side. With `spoiled`, one of the nodes stands where no cell is: they
/// are candidates that nothing can be read from.
inline std::function<bool(int, int)> Markers(int width, int height, int n, int unit, bool spoiled) {
  Canvas canvas(width, height);
  DrawnMarker marker{n, 0, unit};
  const int step = marker.side() + 2 * unit;
  for (marker.y = unit; marker.y + marker.side() < height; marker.y += step) {
    for (marker.x = unit; marker.x + marker.side() < width; marker.x += step, ++marker.id) {
      Draw(marker, &canvas);
      if (!spoiled) continue;
      canvas.Fill(marker.node_x(n - 1), marker.node_y(n - 1), 3 * unit, 3 * unit, true);
      canvas.Fill(marker.node_x(n - 1) - unit / 2, marker.y + 1, 3 * unit, unit / 2, false);
    }
  }
  return [bits = canvas.Bits()](int x, int y) { return IsWhite(bits, x, y); };
}

/// White squares with a grid of dots: as many as a marker has nodes, without a baseline node.
inline std::function<bool(int, int)> Doubts(int side, int dots) {
  return [=](int x, int y) {
    const int u = x % side, v = y % side;
    if (u == 0 || v == 0) return false;
    const int pitch = (side - 1) / dots;
    const bool is_dot = u / pitch < dots && v / pitch < dots && u % pitch >= pitch / 2 &&
                        v % pitch >= pitch / 2 && u < side - 1 && v < side - 1;
    return !is_dot;
  };
}

/// White areas with just what a candidate of 3 x 3 has, as small as the noise limit lets them be.
inline bool IsTinyCandidate(int x, int y) {
  static constexpr const char* kCell[] = {
      "............", ".###########", ".#.....#####", ".#.#.#.#.#.#", ".#.....#####",
      ".#######.#.#", ".###########", ".#.#.#.#####", ".###########", ".###########",
  };
  return kCell[y % 10][x % 12] == '#';
}

/// One white area with 4 x 4 nodes, each full of holes: all of them are measured and counted.
inline std::function<bool(int, int)> NodesFullOfHoles(int width, int height) {
  const int cell_w = width / 4, cell_h = height / 4;
  return [=](int x, int y) {
    const int u = x % cell_w, v = y % cell_h;
    if (x == 0 || y == 0 || x >= width - 1 || y >= height - 1) return false;
    if (std::min({u, v, cell_w - 1 - u, cell_h - 1 - v}) < 3) return true;
    return u % 2 == 0 && v % 3 == 0 && std::min({u, v, cell_w - 1 - u, cell_h - 1 - v}) > 3;
  };
}

}  // namespace pattern_internal

/// Where the colour of a block changes as often as the noise limit allows, or nearly.
inline std::vector<Pattern> PatternsAtTheNoiseLimit() {
  return {
      {"dots of 2 x 3", [](int x, int y) { return x % 2 == 0 && y % 3 == 0; }},
      {"dots of 3 x 2", [](int x, int y) { return x % 3 == 0 && y % 2 == 0; }},
      {"dots of 3 x 2, shifted", [](int x, int y) { return (x + y / 2) % 3 == 0 && y % 2 == 0; }},
      {"holes of 2 x 3", [](int x, int y) { return x % 2 != 0 || y % 3 != 0; }},
      {"holes of 3 x 2", [](int x, int y) { return x % 3 != 0 || y % 2 != 0; }},
      {"six rows of dots", [](int x, int y) { return x % 2 == 0 && y % 16 < 12 && y % 2 == 0; }},
      {"six rows of holes", [](int x, int y) { return x % 2 != 0 || y % 16 >= 12 || y % 2 != 0; }},
      {"slanted stripes, period 6", [](int x, int y) { return (x + y) % 6 < 3; }},
      {"24 changes a row", [](int x, int y) { return x % 64 < 48 && (x + y) % 4 < 2; }},
  };
}

inline std::vector<Pattern> PeriodicPatterns(int width, int height) {
  std::vector<Pattern> patterns;
  const int w = width, h = height;
  for (int p = 1; p <= 8; ++p) {
    const auto add = [&](const char* name, std::function<bool(int, int)> white) {
      patterns.push_back({name + std::string(" of period ") + std::to_string(p), std::move(white)});
    };
    add("checkerboard", [=](int x, int y) { return (x / p + y / p) % 2 != 0; });
    add("upright stripes", [=](int x, int) { return x / p % 2 != 0; });
    add("level stripes", [=](int, int y) { return y / p % 2 != 0; });
    add("slanted stripes", [=](int x, int y) { return (x + y) / p % 2 != 0; });
    add("comb", [=](int x, int y) { return x / p % 2 == 0 || y < p; });
    add("comb from below", [=](int x, int y) { return x / p % 2 == 0 || h - 1 - y < p; });
    add("meander",
        [=](int x, int y) { return y / p % 2 == 0 || (y / p % 4 == 1 ? x < p : w - 1 - x < p); });
    add("spiral", [=](int px, int py) {
      const int x = px / p, y = py / p;
      const int depth = std::min({x, y, (w - 1) / p - x, (h - 1) / p - y});
      return (depth % 2 == 0) != (x == depth && y == depth + 1);
    });
    add("nested rings", [=](int x, int y) {
      return std::min({x, y, w - 1 - x, h - 1 - y}) / p % 2 != 0;
    });
    add("nested diamonds",
        [=](int x, int y) { return (std::abs(x - w / 2) + std::abs(y - h / 2)) / p % 2 != 0; });
    add("nested U", [=](int x, int y) { return std::min({x, w - 1 - x, h - 1 - y}) / p % 2 != 0; });
    add("rows of U", [=](int x, int y) {
      const int u = x % (8 * p), v = y % (8 * p);
      return std::min({u, 8 * p - 1 - u, 8 * p - 1 - v}) / p % 2 != 0;
    });
    // Teeth of 45 degrees: every run begins a component that ends in the one beside it.
    add("saw teeth", [=](int x, int y) {
      const int u = x % (4 * p), v = y % (2 * p);
      return std::abs(u - 2 * p) < v + 1;
    });
    add("staircase", [=](int x, int y) { return (x - y + 4 * h) % (3 * p) < p; });
  }
  return patterns;
}

inline std::vector<Pattern> NoisePatterns(int width, int height) {
  std::vector<Pattern> patterns;
  for (int percent = 1; percent <= 50; ++percent) {
    patterns.push_back({"noise, " + std::to_string(percent) + " % white",
                        pattern_internal::Cells(width, height, percent, 1)});
  }
  for (const int percent : {75, 80, 90}) {
    patterns.push_back({"noise, " + std::to_string(percent) + " % white",
                        pattern_internal::Cells(width, height, percent, 2)});
  }
  return patterns;
}

/// What costs the stages behind the labelling.
inline std::vector<Pattern> CandidatePatterns(int width, int height) {
  using pattern_internal::Doubts;
  using pattern_internal::Markers;
  return {
      {"markers of 26 pixels", Markers(width, height, 3, 2, false)},
      {"markers of 34 pixels", Markers(width, height, 4, 2, false)},
      {"markers of 66 pixels", Markers(width, height, 8, 2, false)},
      {"unreadable markers of 26 pixels", Markers(width, height, 3, 2, true)},
      {"unreadable markers of 66 pixels", Markers(width, height, 8, 2, true)},
      {"tiny candidates", pattern_internal::IsTinyCandidate},
      {"nodes full of holes", pattern_internal::NodesFullOfHoles(width, height)},
      {"doubts of 13 pixels", Doubts(13, 3)},
      {"doubts of 21 pixels", Doubts(21, 4)},
      {"doubts of 160 pixels", Doubts(160, 7)},
      {"doubts of 130 pixels with 81 dots", Doubts(130, 9)},
  };
}

inline std::vector<Pattern> AllPatterns(int width, int height) {
  std::vector<Pattern> all = PatternsAtTheNoiseLimit();
  for (auto make : {PeriodicPatterns, NoisePatterns, CandidatePatterns}) {
    for (Pattern& pattern : make(width, height)) all.push_back(std::move(pattern));
  }
  return all;
}

/// On two grey levels.
inline PaddedImage Draw(const Pattern& pattern, int width, int height) {
  PaddedImage image(width, height, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.row(y)[x] = pattern.white(x, y) ? 220 : 30;
  }
  return image;
}

}  // namespace topotag

#endif  // TOPOTAG_TESTS_WORST_PATTERNS_H_
