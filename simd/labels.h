#ifndef TOPOTAG_SIMD_LABELS_H_
#define TOPOTAG_SIMD_LABELS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "host/pipeline.h"

namespace topotag::simd {

/// Union-find over labels; the smaller root wins, so that roots stay in raster order.
class Labels {
 public:
  explicit Labels(Components* components)
      : root_(components->root.data()),
        parent_(components->parent.data()),
        white_(components->white.data()) {}

  uint32_t FindRoot(uint32_t label) {
    while (root_[label] != label) {
      root_[label] = root_[root_[label]];
      label = root_[label];
    }
    return label;
  }
  uint32_t Unite(uint32_t a, uint32_t b) {
    a = FindRoot(a);
    b = FindRoot(b);
    if (a == b) return a;  // label 0 is shared by all strips and never written
    root_[std::max(a, b)] = std::min(a, b);
    return std::min(a, b);
  }
  void Add(uint32_t label, uint32_t left, bool white) {
    root_[label] = label;
    parent_[label] = left;
    white_[label] = white;
  }
  uint32_t* root(uint32_t label) { return root_ + label; }
  uint32_t* parent(uint32_t label) { return parent_ + label; }
  uint8_t* white(uint32_t label) { return white_ + label; }

 private:
  uint32_t* root_;
  uint32_t* parent_;
  uint8_t* white_;
};

/// Pairs of labels that turned out to be one component's, to be united later, many at a time: then
/// the vectors that find them never wait for what a search for a root mispredicts.
struct Equivalences {
  static constexpr size_t kCapacity = 256;
  /// Vectors are stored behind the last pair.
  static constexpr size_t kSlack = 32;

  void Add(uint32_t label, uint32_t other, Labels* labels) {
    a[count] = label;
    b[count++] = other;
    Unite(kCapacity, labels);
  }
  /// Unites the pairs if there are at least `min`.
  void Unite(size_t min, Labels* labels) {
    if (count < min) return;
    for (size_t i = 0; i < count; ++i) labels->Unite(a[i], b[i]);
    count = 0;
  }

  size_t count = 0;
  uint32_t a[kCapacity + kSlack];
  uint32_t b[kCapacity + kSlack];
};

/// The runs of one row.
struct Row {
  Row(Components* components, int y)
      : runs(static_cast<int>(components->row_runs[static_cast<size_t>(y)])),
        bound(components->bound.data() + components->row_begin[static_cast<size_t>(y)]),
        label(components->label.data() + components->row_begin[static_cast<size_t>(y)]) {}

  int runs;
  const int16_t* bound;
  uint32_t* label;
};

/// Black runs also touch by a corner.
inline int Reach(int run) { return 1 - (run & 1); }

/// Calls touch(i, k) for every run i of `row` and run k of the same colour above that touch.
template <typename Touch>
void ForContacts(const Row& above, const Row& row, const Touch& touch) {
  int first[2] = {0, 1};  // by colour, the first run above that may still touch
  for (int i = 0; i < row.runs; ++i) {
    int& j = first[i & 1];
    const int begin = row.bound[i] - Reach(i);
    const int end = row.bound[i + 1] + Reach(i);
    while (j < above.runs && above.bound[j + 1] <= begin) j += 2;
    for (int k = j; k < above.runs && above.bound[k] < end; k += 2) touch(i, k);
  }
}

/// Labels the first row of a strip as if nothing but the outside touched it.
inline uint32_t LabelFirstRow(const Row& row, uint32_t next, Labels* labels) {
  row.label[0] = 0;
  for (int i = 1; i < row.runs - 1; ++i) {
    labels->Add(next, row.label[i - 1], (i & 1) != 0);
    row.label[i] = next++;
  }
  row.label[row.runs - 1] = 0;
  return next;
}

}  // namespace topotag::simd

#endif  // TOPOTAG_SIMD_LABELS_H_
