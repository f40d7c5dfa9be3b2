#include "fallback/label.h"

#include <algorithm>
#include <cstddef>

namespace topotag::scalar {
namespace {

// Pixels of one word that differ from their left neighbour.
uint64_t Changes(const uint64_t* row, int word) {
  const uint64_t left = word == 0 ? 0 : row[word - 1] >> 63;
  return row[word] ^ (row[word] << 1 | left);
}

// Copies the rows of one band of blocks; blocks above the noise limit become black.
void CopyReadableBlocks(const BitImage& bits, int first_row, int rows, uint64_t* readable) {
  for (int word = 0; word < bits.words; ++word) {
    int changes = 0;
    for (int y = 0; y < rows; ++y) {
      changes += __builtin_popcountll(Changes(bits.row(first_row + y), word));
    }
    const bool is_noise = changes > kMaxBlockChanges;
    for (int y = 0; y < rows; ++y) {
      readable[y * bits.words + word] = is_noise ? 0 : bits.row(first_row + y)[word];
    }
  }
}

// Writes the bounds of one row's runs; returns how many runs.
uint32_t FindRuns(const uint64_t* row, int words, int16_t* bound) {
  int16_t* out = bound;
  *out++ = -1;
  for (int word = 0; word < words; ++word) {
    for (uint64_t change = Changes(row, word); change != 0; change &= change - 1) {
      *out++ = static_cast<int16_t>(word * 64 + __builtin_ctzll(change));
    }
  }
  // White up to the last bit of the last word: the outside begins right after it.
  if (row[words - 1] >> 63 != 0) *out++ = static_cast<int16_t>(words * 64);
  *out = Components::kOutsideBound;
  return static_cast<uint32_t>(out - bound);
}

// Runs of all rows, one after the other. A block may gain a change in each row where the one to its
// left becomes black.
void FindAllRuns(const BitImage& bits, LabelWorkspace* ws, Components* components) {
  const auto words = static_cast<size_t>(bits.words);
  const auto height = static_cast<size_t>(bits.height);
  const size_t bands = (height + kBlockRows - 1) / kBlockRows;
  const size_t max_bounds = bands * words * (kMaxBlockChanges + kBlockRows) + 3 * height;
  components->row_begin.Reserve(height);
  components->row_runs.Reserve(height);
  components->bound.Reserve(max_bounds);
  components->label.Reserve(max_bounds);
  ws->readable.Reserve(words * kBlockRows);
  uint32_t begin = 0;
  for (int first_row = 0; first_row < bits.height; first_row += kBlockRows) {
    const int rows = std::min(kBlockRows, bits.height - first_row);
    CopyReadableBlocks(bits, first_row, rows, ws->readable.data());
    for (int y = 0; y < rows; ++y) {
      const uint64_t* row = ws->readable.data() + static_cast<size_t>(y) * words;
      const uint32_t runs = FindRuns(row, bits.words, components->bound.data() + begin);
      components->row_begin[static_cast<size_t>(first_row + y)] = begin;
      components->row_runs[static_cast<size_t>(first_row + y)] = runs;
      begin += runs + 1;
    }
  }
}

uint32_t FindRoot(std::vector<uint32_t>& root, uint32_t label) {
  while (root[label] != label) {
    root[label] = root[root[label]];
    label = root[label];
  }
  return label;
}

uint32_t Unite(std::vector<uint32_t>& root, uint32_t a, uint32_t b) {
  a = FindRoot(root, a);
  b = FindRoot(root, b);
  if (b < a) std::swap(a, b);
  root[b] = a;
  return a;
}

// The runs of one row.
struct Row {
  explicit Row(Components* components, int y)
      : runs(static_cast<int>(components->row_runs[static_cast<size_t>(y)])),
        bound(components->bound.data() + components->row_begin[static_cast<size_t>(y)]),
        label(components->label.data() + components->row_begin[static_cast<size_t>(y)]) {}

  int begin(int run) const { return bound[run]; }
  int end(int run) const { return bound[run + 1]; }

  int runs;
  const int16_t* bound;
  uint32_t* label;
};

// Joins each run with the runs of its colour above that it touches: white ones by an edge, black
// ones by an edge or a corner. A run that touches none starts a component.
void LabelRow(const Row* above, const Row& row, LabelWorkspace* ws) {
  int first[2] = {0, 1};  // by colour, the first run above that may still be touched
  for (int run = 0; run < row.runs; ++run) {
    const int white = run & 1;
    const int reach = white ? 0 : 1;
    const int begin = row.begin(run) - reach;
    const int end = row.end(run) + reach;
    int& touched = first[white];
    bool found = run == 0 || run == row.runs - 1;
    uint32_t label = 0;
    if (above != nullptr) {
      while (touched < above->runs && above->end(touched) <= begin) touched += 2;
      for (int i = touched; i < above->runs && above->begin(i) < end; i += 2) {
        label =
            found ? Unite(ws->root, label, above->label[i]) : FindRoot(ws->root, above->label[i]);
        found = true;
      }
    }
    if (!found) {
      label = static_cast<uint32_t>(ws->root.size());
      ws->root.push_back(label);
      ws->parent.push_back(row.label[run - 1]);
    }
    row.label[run] = label;
  }
}

// Turns provisional labels into component numbers. Roots are the smallest labels of their
// components, and labels grow in raster order, so counting the roots gives the canonical order.
void Renumber(LabelWorkspace* ws, Components* components) {
  std::vector<uint32_t>& number = ws->root;
  components->root.Reserve(number.size());
  components->parent.Reserve(number.size());
  components->white.Reserve(number.size());
  uint32_t count = 0;
  for (size_t label = 0; label < number.size(); ++label) {
    if (number[label] != label) {
      number[label] = number[number[label]];  // its root is smaller: numbered already
      continue;
    }
    const uint32_t parent = label == 0 ? 0 : number[ws->parent[label]];
    components->root[count] = count;
    components->parent[count] = parent;
    components->white[count] = label == 0 ? 0 : !components->white[parent];
    number[label] = count++;
  }
  components->ranges.assign(1, {0, count});
  for (int y = 0; y < components->height; ++y) {
    const Row row(components, y);
    for (int run = 0; run < row.runs; ++run) row.label[run] = number[row.label[run]];
  }
}

}  // namespace

void Label(const BitImage& bits, LabelWorkspace* workspace, Components* components) {
  components->width = bits.width;
  components->height = bits.height;
  FindAllRuns(bits, workspace, components);
  workspace->root.assign(1, 0);
  workspace->parent.assign(1, 0);
  for (int y = 0; y < bits.height; ++y) {
    const Row row(components, y);
    if (y == 0) {
      LabelRow(nullptr, row, workspace);
    } else {
      const Row above(components, y - 1);
      LabelRow(&above, row, workspace);
    }
  }
  // Black runs of the first and the last row touch the outside.
  for (const int y : {0, bits.height - 1}) {
    const Row row(components, y);
    for (int run = 0; run < row.runs; run += 2) Unite(workspace->root, 0, row.label[run]);
  }
  Renumber(workspace, components);
}

void Measure(const Components& components, const uint32_t* slot, size_t slots, Feature* features) {
  std::fill_n(features, slots, Feature());
  for (int y = 0; y < components.height; ++y) {
    const auto row = static_cast<size_t>(y);
    const uint32_t* label = components.label.data() + components.row_begin[row];
    const int16_t* bound = components.bound.data() + components.row_begin[row];
    for (uint32_t run = 0; run < components.row_runs[row]; ++run) {
      const uint32_t s = slot[label[run]];
      if (s == 0) continue;
      const int begin = bound[run];
      const int end = bound[run + 1];
      const int length = end - begin;
      Feature& feature = features[s];
      feature.area += static_cast<uint32_t>(length);
      feature.sum_x += static_cast<int64_t>(begin + end - 1) * length / 2;
      feature.sum_y += static_cast<int64_t>(y) * length;
      feature.min_x = std::min(feature.min_x, static_cast<uint16_t>(begin));
      feature.max_x = std::max(feature.max_x, static_cast<uint16_t>(end - 1));
      feature.min_y = std::min(feature.min_y, static_cast<uint16_t>(y));
      feature.max_y = std::max(feature.max_y, static_cast<uint16_t>(y));
    }
  }
}

}  // namespace topotag::scalar
