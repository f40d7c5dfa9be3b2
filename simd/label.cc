#include "simd/label.h"

#include <algorithm>
#include <cstddef>

#include "host/workers.h"
#include "simd/runs.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/label.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

#ifndef TOPOTAG_SIMD_LABEL_ONCE
#define TOPOTAG_SIMD_LABEL_ONCE
namespace topotag::simd {
namespace {

// Union-find over labels; the smaller root wins, so that roots stay in raster order.
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

 private:
  uint32_t* root_;
  uint32_t* parent_;
  uint8_t* white_;
};

struct Row {
  Row(Components* components, int y)
      : runs(static_cast<int>(components->row_runs[static_cast<size_t>(y)])),
        bound(components->bound.data() + components->row_begin[static_cast<size_t>(y)]),
        label(components->label.data() + components->row_begin[static_cast<size_t>(y)]) {}

  int runs;
  const int16_t* bound;
  uint32_t* label;
};

// Black runs also touch by a corner.
inline int Reach(int run) { return 1 - (run & 1); }

}  // namespace
}  // namespace topotag::simd
#endif  // TOPOTAG_SIMD_LABEL_ONCE

HWY_BEFORE_NAMESPACE();
namespace topotag::simd {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<int16_t, 16> kBounds;
constexpr hn::CappedTag<uint32_t, 16> kLabels;

// Copies the labels of runs from run `i` of `row` on that correspond to those from run `j` above
// on, one to one, and returns how many. Bound i lies strictly between bounds j - 1 and j + 1 above;
// while the following ones do likewise, each run touches its counterpart and no other. No run of
// the row above ends behind kOutsideBound, so the last run never corresponds.
HWY_INLINE int CopyCoherent(const Row& above, const Row& row, int i, int j) {
  const int lanes = static_cast<int>(hn::Lanes(kBounds));
  const int label_lanes = static_cast<int>(hn::Lanes(kLabels));
  for (int copied = 0;; copied += lanes) {
    const int16_t* a = above.bound + j + copied;
    const auto own = hn::LoadU(kBounds, row.bound + i + copied + 1);
    const auto inside =
        hn::And(hn::Lt(hn::LoadU(kBounds, a), own), hn::Lt(own, hn::LoadU(kBounds, a + 2)));
    for (int k = 0; k < lanes; k += label_lanes) {
      hn::StoreU(hn::LoadU(kLabels, above.label + j + copied + k), kLabels,
                 row.label + i + copied + k);
    }
    const intptr_t end = hn::FindFirstTrue(kBounds, hn::Not(inside));
    if (end >= 0) return copied + static_cast<int>(end);
  }
}

// Labels one row; returns the next free label.
uint32_t LabelRow(const Row& above, const Row& row, uint32_t next, Labels* labels) {
  const int16_t* a = above.bound;
  const int16_t* b = row.bound;
  int i = 0;
  int j = 0;  // run above of the same colour; none of those before it touches run i
  for (;;) {
    if (a[j - 1] < b[i] && b[i] < a[j + 1]) {
      const int copied = CopyCoherent(above, row, i, j);
      i += copied;
      j += copied;
    }
    const int reach = Reach(i);
    const int begin = b[i] - reach;
    const int end = b[i + 1] + reach;
    while (a[j + 1] <= begin) j += 2;
    if (i == row.runs - 1) break;
    if (a[j] < end) {
      uint32_t label = above.label[j];
      while (a[j + 2] < end) {
        j += 2;
        label = labels->Unite(label, above.label[j]);
      }
      row.label[i] = label;
      ++j;
    } else {
      labels->Add(next, row.label[i - 1], (i & 1) != 0);
      row.label[i] = next++;
      --j;
    }
    ++i;
  }
  row.label[i] = 0;
  for (; j < above.runs; j += 2) labels->Unite(0, above.label[j]);
  return next;
}

}  // namespace

// Labels the rows of a strip on their own, with labels from strip->labels.begin on.
void LabelStrip(Components* components, Strip* strip) {
  Labels labels(components);
  uint32_t next = std::max(strip->labels.begin, 1u);
  Row above(components, strip->row_begin);
  above.label[0] = 0;
  for (int i = 1; i < above.runs - 1; ++i) {
    labels.Add(next, above.label[i - 1], (i & 1) != 0);
    above.label[i] = next++;
  }
  above.label[above.runs - 1] = 0;
  for (int y = strip->row_begin + 1; y < strip->row_end; ++y) {
    const Row row(components, y);
    next = LabelRow(above, row, next, &labels);
    above = row;
  }
  strip->labels.end = next;
}

}  // namespace HWY_NAMESPACE
}  // namespace topotag::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag::simd {
namespace {

HWY_EXPORT(LabelStrip);

// Below so many runs a second strip costs more than it saves.
constexpr size_t kMinRunsPerStrip = 1000;

// One strip a thread, with about as many runs each, of whole bands: vectors of labels reach beyond
// the end of a row, but not out of its band's region. Returns a bound of all labels.
uint32_t CutStrips(const Components& components, int threads, std::vector<Strip>* strips) {
  strips->clear();
  size_t total = 0;
  for (size_t y = 0; y < static_cast<size_t>(components.height); ++y) {
    total += components.row_runs[y];
  }
  const size_t count =
      std::clamp<size_t>(total / kMinRunsPerStrip, 1, static_cast<size_t>(threads));
  Strip strip{0, 0, {0, 0}};
  size_t runs = 0;
  uint32_t labels = 1;  // 0 is the outside
  for (int y = 0; y < components.height; ++y) {
    runs += components.row_runs[static_cast<size_t>(y)];
    labels += components.row_runs[static_cast<size_t>(y)];
    const bool is_end = y + 1 == components.height ||
                        ((y + 1) % kBlockRows == 0 && runs * count >= total * (strips->size() + 1));
    if (!is_end) continue;
    strip.row_end = y + 1;
    strips->push_back(strip);
    strip = {y + 1, y + 1, {labels, labels}};
  }
  return labels;
}

// Joins the runs of the first row of a strip with those of the last row before it.
void MergeRows(const Row& above, const Row& row, Labels* labels, std::vector<uint32_t>* merged) {
  const auto unite = [&](uint32_t a, uint32_t b) {
    a = labels->FindRoot(a);
    b = labels->FindRoot(b);
    if (a == b) return;
    labels->Unite(a, b);
    merged->push_back(std::max(a, b));
  };
  int first[2] = {0, 1};
  for (int i = 0; i < row.runs; ++i) {
    int& j = first[i & 1];
    const int begin = row.bound[i] - Reach(i);
    const int end = row.bound[i + 1] + Reach(i);
    while (j < above.runs && above.bound[j + 1] <= begin) j += 2;
    for (int k = j; k < above.runs && above.bound[k] < end; k += 2) {
      unite(row.label[i], above.label[k]);
    }
  }
}

// Black runs of the first and the last row touch the outside.
void MergeOutside(const Row& row, Labels* labels) {
  for (int i = 0; i < row.runs; i += 2) labels->Unite(0, row.label[i]);
}

// Lets every label of a strip, and every root's parent, point to its root.
void Flatten(const Strip& strip, Components* components) {
  uint32_t* root = components->root.data();
  uint32_t* parent = components->parent.data();
  for (uint32_t label = strip.labels.begin; label < strip.labels.end; ++label) {
    if (root[label] != label) {
      root[label] = root[root[label]];
    } else {
      parent[label] = root[parent[label]];
    }
  }
}

}  // namespace

void Label(const BitImage& bits, Workers* workers, LabelWorkspace* workspace,
           Components* components) {
  FindRuns(bits, workers, components);
  std::vector<Strip>& strips = workspace->strips;
  const uint32_t max_labels = CutStrips(*components, workers->threads(), &strips);
  components->root.Reserve(max_labels);
  components->parent.Reserve(max_labels);
  components->white.Reserve(max_labels);
  Labels labels(components);
  labels.Add(0, 0, false);
  const int count = static_cast<int>(strips.size());
  workers->For(count, [&](int i) {
    HWY_DYNAMIC_DISPATCH(LabelStrip)(components, &strips[static_cast<size_t>(i)]);
  });

  workspace->merged.clear();
  for (const Strip& strip : strips) {
    if (strip.row_begin == 0) continue;
    MergeRows(Row(components, strip.row_begin - 1), Row(components, strip.row_begin), &labels,
              &workspace->merged);
  }
  MergeOutside(Row(components, 0), &labels);
  MergeOutside(Row(components, bits.height - 1), &labels);
  for (const uint32_t label : workspace->merged) {
    components->root[label] = labels.FindRoot(label);
  }
  workers->For(count, [&](int i) { Flatten(strips[static_cast<size_t>(i)], components); });
  components->ranges.clear();
  for (const Strip& strip : strips) components->ranges.push_back(strip.labels);
}

}  // namespace topotag::simd
#endif  // HWY_ONCE
