#ifndef TOPOTAG_TESTS_PARITY_H_
#define TOPOTAG_TESTS_PARITY_H_

// Comparisons of what two backends made of the same frame. Each returns the first difference, with
// its stage, place and both values, and an empty text where there is none.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "host/canonical.h"
#include "host/pipeline.h"
#include "tests/random_image.h"

namespace topotag {

namespace parity_internal {

template <typename... Parts>
std::string Text(const Parts&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  return text.str();
}

template <typename T>
std::string Unequal(const std::string& what, const T& expected, const T& actual) {
  return Text(what, ": ", +actual, " instead of ", +expected);
}

}  // namespace parity_internal

/// Of an array of `cols` values a row.
template <typename T>
std::string Difference(const std::string& what, int cols, const std::vector<T>& expected,
                       const std::vector<T>& actual) {
  using parity_internal::Text;
  using parity_internal::Unequal;
  if (expected.size() != actual.size()) {
    return Unequal(what + ", size", expected.size(), actual.size());
  }
  const size_t i = static_cast<size_t>(
      std::mismatch(expected.begin(), expected.end(), actual.begin()).first - expected.begin());
  if (i == expected.size()) return "";
  const auto n = static_cast<size_t>(cols);
  return Unequal(Text(what, ", row ", i / n, ", column ", i % n), expected[i], actual[i]);
}

inline std::string Difference(const ThresholdGrid& expected, const ThresholdGrid& actual) {
  using parity_internal::Unequal;
  if (expected.cols != actual.cols) return Unequal("grid columns", expected.cols, actual.cols);
  if (expected.rows != actual.rows) return Unequal("grid rows", expected.rows, actual.rows);
  std::string difference = Difference("threshold", expected.cols, expected.value, actual.value);
  if (difference.empty()) {
    difference = Difference("floor of tiles", expected.cols - 1, expected.floor, actual.floor);
  }
  if (difference.empty()) {
    difference =
        Difference("ceiling of tiles", expected.cols - 1, expected.ceiling, actual.ceiling);
  }
  return difference;
}

inline std::string Difference(const BitImage& expected, const BitImage& actual) {
  using parity_internal::Text;
  using parity_internal::Unequal;
  if (expected.width != actual.width) return Unequal("bit width", expected.width, actual.width);
  if (expected.height != actual.height) {
    return Unequal("bit height", expected.height, actual.height);
  }
  if (expected.words != actual.words) return Unequal("bit words", expected.words, actual.words);
  if (expected.bits == actual.bits) return "";
  if (expected.bits.size() != actual.bits.size()) {
    return Unequal("bit size", expected.bits.size(), actual.bits.size());
  }
  for (int y = 0; y < expected.height; ++y) {
    for (int word = 0; word < expected.words; ++word) {
      const uint64_t a = expected.row(y)[word], b = actual.row(y)[word];
      if (a == b) continue;
      const int bit = __builtin_ctzll(a ^ b);
      return Unequal(Text("bit, row ", y, ", column ", 64 * word + bit), a >> bit & 1,
                     b >> bit & 1);
    }
  }
  return "bits before the first or behind the last row";
}

/// What is wrong with the labels of one backend by themselves.
inline std::string Flaw(const Components& components) {
  using parity_internal::Text;
  if (components.ranges.empty() || components.ranges[0].begin != 0) {
    return "the ranges of labels do not begin with 0";
  }
  std::vector<bool> used(components.label_end());
  uint32_t end = 0;
  for (const auto& range : components.ranges) {
    if (range.begin < end || range.end < range.begin) return "ranges of labels overlap";
    end = range.end;
    std::fill(used.begin() + range.begin, used.begin() + range.end, true);
  }
  for (uint32_t label = 0; label < end; ++label) {
    if (!used[label]) continue;
    const uint32_t root = components.root[label];
    if (root > label || !used[root] || components.root[root] != root) {
      return Text("label ", label, " has root ", root);
    }
    if (root != label) continue;
    const uint32_t parent = components.parent[label];
    const bool is_smaller = label == 0 ? parent == 0 : parent < label;
    if (!is_smaller || !used[parent] || components.root[parent] != parent) {
      return Text("component ", label, " has parent ", parent);
    }
    if (components.white[label] > 1) return Text("colour of component ", label);
  }
  for (size_t y = 0; y < static_cast<size_t>(components.height); ++y) {
    const uint32_t begin = components.row_begin[y];
    for (uint32_t run = 0; run < components.row_runs[y]; ++run) {
      const uint32_t label = components.label[begin + run];
      if (label >= end || !used[label]) {
        return Text("label ", label, " of row ", y, ", run ", run, " is not in use");
      }
    }
  }
  return "";
}

/// Of the runs, and of the components as CanonicalComponents numbers them.
inline std::string Difference(const Components& expected, const Components& actual) {
  using parity_internal::Text;
  using parity_internal::Unequal;
  if (expected.width != actual.width) return Unequal("label width", expected.width, actual.width);
  if (expected.height != actual.height) {
    return Unequal("label height", expected.height, actual.height);
  }
  for (size_t y = 0; y < static_cast<size_t>(expected.height); ++y) {
    const uint32_t runs = expected.row_runs[y];
    if (actual.row_runs[y] != runs) {
      return Unequal(Text("runs of row ", y), runs, actual.row_runs[y]);
    }
    for (uint32_t run = 0; run <= runs; ++run) {
      const int16_t a = expected.bound[expected.row_begin[y] + run];
      const int16_t b = actual.bound[actual.row_begin[y] + run];
      if (a != b) return Unequal(Text("bound of row ", y, ", run ", run), a, b);
    }
  }
  if (const std::string flaw = Flaw(actual); !flaw.empty()) return flaw;
  const CanonicalComponents canonical(expected), other(actual);
  for (size_t y = 0; y < static_cast<size_t>(expected.height); ++y) {
    for (uint32_t run = 0; run < expected.row_runs[y]; ++run) {
      const uint32_t a = canonical.number[expected.label[expected.row_begin[y] + run]];
      const uint32_t b = other.number[actual.label[actual.row_begin[y] + run]];
      if (a == b) continue;
      const int x = expected.bound[expected.row_begin[y] + run];
      return Unequal(Text("component of row ", y, ", run ", run, ", column ", x), a, b);
    }
  }
  if (canonical.white.size() != other.white.size()) {
    return Unequal("components", canonical.white.size(), other.white.size());
  }
  for (size_t i = 0; i < canonical.white.size(); ++i) {
    if (canonical.white[i] != other.white[i]) {
      return Unequal(Text("colour of component ", i), canonical.white[i], other.white[i]);
    }
    if (canonical.parent[i] != other.parent[i]) {
      return Unequal(Text("parent of component ", i), canonical.parent[i], other.parent[i]);
    }
  }
  return "";
}

/// Of the features of slots 1 .. slots - 1.
inline std::string Difference(const Feature* expected, const Feature* actual, size_t slots) {
  using parity_internal::Text;
  using parity_internal::Unequal;
  for (size_t i = 1; i < slots; ++i) {
    const Feature &a = expected[i], &b = actual[i];
    if (a.area != b.area) return Unequal(Text("area of slot ", i), a.area, b.area);
    if (a.sum_x != b.sum_x) return Unequal(Text("sum x of slot ", i), a.sum_x, b.sum_x);
    if (a.sum_y != b.sum_y) return Unequal(Text("sum y of slot ", i), a.sum_y, b.sum_y);
    if (a.min_x != b.min_x) return Unequal(Text("min x of slot ", i), a.min_x, b.min_x);
    if (a.min_y != b.min_y) return Unequal(Text("min y of slot ", i), a.min_y, b.min_y);
    if (a.max_x != b.max_x) return Unequal(Text("max x of slot ", i), a.max_x, b.max_x);
    if (a.max_y != b.max_y) return Unequal(Text("max y of slot ", i), a.max_y, b.max_y);
  }
  return "";
}

/// Slots of components by canonical number, in random order: of about `percent` of them; the
/// outside has none.
inline std::vector<uint32_t> RandomSlots(size_t components, int percent, Random* random,
                                         size_t* slots) {
  std::vector<uint32_t> slot(components);
  uint32_t next = 1;
  for (size_t i = 1; i < components; ++i) slot[i] = random->Chance(percent) ? next++ : 0;
  for (size_t i = 2; i < components; ++i) {
    std::swap(slot[i], slot[static_cast<size_t>(random->Between(1, static_cast<int>(i)))]);
  }
  *slots = next;
  return slot;
}

/// The same slots by the labels of `components`. Labels that are not in use have one that no stage
/// may look at.
template <typename Slots>
void SlotsOfLabels(const Components& components, const std::vector<uint32_t>& slot,
                   Slots* label_slot) {
  const CanonicalComponents canonical(components);
  std::fill_n(label_slot->data(), components.label_end(), 0x7fffffffU);
  for (const auto& [begin, end] : components.ranges) {
    for (uint32_t label = begin; label < end; ++label) {
      (*label_slot)[label] = slot[canonical.number[label]];
    }
  }
}

}  // namespace topotag

#endif  // TOPOTAG_TESTS_PARITY_H_
