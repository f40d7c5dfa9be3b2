#ifndef TOPOTAG_TESTS_FLOOD_FILL_H_
#define TOPOTAG_TESTS_FLOOD_FILL_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/pipeline.h"
#include "tests/random_image.h"

namespace topotag {

// The picture without the blocks above the noise limit, by its definition, pixel by pixel.
inline BitImage WithoutNoise(const BitImage& bits) {
  const auto is_noise = [&bits](int left, int top) {
    int changes = 0;
    for (int y = top; y < std::min(top + kBlockRows, bits.height); ++y) {
      for (int x = left; x < left + 64; ++x) {
        // What lies outside the picture is black.
        const bool white = x < bits.width && IsWhite(bits, x, y);
        const bool left_white = x > 0 && x - 1 < bits.width && IsWhite(bits, x - 1, y);
        changes += white != left_white ? 1 : 0;
      }
    }
    return changes > kMaxBlockChanges;
  };
  std::vector<bool> noise;
  for (int y = 0; y < bits.height; y += kBlockRows) {
    for (int x = 0; x < bits.width; x += 64) noise.push_back(is_noise(x, y));
  }
  return MakeBits(bits.width, bits.height, [&](int x, int y) {
    return IsWhite(bits, x, y) && !noise[static_cast<size_t>(y / kBlockRows * bits.words + x / 64)];
  });
}

// Components by flood filling the picture with a border of one black pixel around it, in raster
// order: so the outside gets 0, and the others the canonical numbers.
class FloodFill {
 public:
  explicit FloodFill(const BitImage& bits) : width_(bits.width + 2), height_(bits.height + 2) {
    white_.resize(static_cast<size_t>(width_) * static_cast<size_t>(height_));
    for (int y = 0; y < bits.height; ++y) {
      for (int x = 0; x < bits.width; ++x) white_[At(x, y)] = IsWhite(bits, x, y);
    }
    label_.assign(white_.size(), -1);
    for (size_t at = 0; at < white_.size(); ++at) {
      if (label_[at] >= 0) continue;
      Fill(at, static_cast<int>(first_.size()));
      first_.push_back(at);
    }
  }

  size_t size() const { return first_.size(); }
  uint32_t label(int x, int y) const { return static_cast<uint32_t>(label_[At(x, y)]); }
  bool white(size_t component) const { return white_[first_[component]]; }
  uint32_t LeftOfFirstPixel(size_t component) const {
    return component == 0 ? 0 : static_cast<uint32_t>(label_[first_[component] - 1]);
  }

  // Components that share an edge with `component` and without whose pixels no way leads from it
  // to the outside: one step to a side, or across a corner within a black component. The outside
  // itself where there is no other.
  std::vector<uint32_t> Surrounding(size_t component) const {
    std::vector<uint32_t> around;
    bool outside = false;
    for (const int other : Neighbours(static_cast<int>(component))) {
      if (other == 0) outside = true;
      if (other != 0 && !Escapes(static_cast<int>(component), other)) {
        around.push_back(static_cast<uint32_t>(other));
      }
    }
    if (around.empty() && outside) around.push_back(0);
    return around;
  }

 private:
  size_t At(int x, int y) const {
    return static_cast<size_t>(y + 1) * static_cast<size_t>(width_) + static_cast<size_t>(x + 1);
  }

  // Calls visit(neighbour, is_diagonal) for those of the eight that exist.
  template <typename Visit>
  void ForNeighbours(size_t at, Visit visit) const {
    const int x = static_cast<int>(at) % width_, y = static_cast<int>(at) / width_;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (x + dx < 0 || x + dx >= width_ || y + dy < 0 || y + dy >= height_) continue;
        if (dx != 0 || dy != 0) visit(At(x + dx - 1, y + dy - 1), dx != 0 && dy != 0);
      }
    }
  }

  void Fill(size_t start, int label) {
    std::vector<size_t> stack{start};
    label_[start] = label;
    while (!stack.empty()) {
      const size_t at = stack.back();
      stack.pop_back();
      ForNeighbours(at, [&](size_t next, bool diagonal) {
        if (label_[next] >= 0 || white_[next] != white_[at] || (diagonal && white_[at])) return;
        label_[next] = label;
        stack.push_back(next);
      });
    }
  }

  std::vector<int> Neighbours(int component) const {
    std::vector<int> found;
    for (size_t at = 0; at < label_.size(); ++at) {
      if (label_[at] != component) continue;
      ForNeighbours(at, [&](size_t next, bool diagonal) {
        if (!diagonal && label_[next] != component) found.push_back(label_[next]);
      });
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  bool Escapes(int component, int removed) const {
    std::vector<bool> seen(label_.size());
    std::vector<size_t> stack{first_[static_cast<size_t>(component)]};
    seen[stack[0]] = true;
    while (!stack.empty()) {
      const size_t at = stack.back();
      stack.pop_back();
      if (label_[at] == 0) return true;
      ForNeighbours(at, [&](size_t next, bool diagonal) {
        if (seen[next] || label_[next] == removed) return;
        if (diagonal && (white_[at] || label_[next] != label_[at])) return;
        seen[next] = true;
        stack.push_back(next);
      });
    }
    return false;
  }

  int width_;
  int height_;
  std::vector<bool> white_;
  std::vector<int> label_;
  std::vector<size_t> first_;
};

}  // namespace topotag

#endif  // TOPOTAG_TESTS_FLOOD_FILL_H_
