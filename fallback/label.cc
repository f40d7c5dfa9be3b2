#include "fallback/label.h"

#include <algorithm>
#include <cstddef>

namespace topotag::scalar {
namespace {

void AppendTransitions(const BitImage& bits, int y, std::vector<uint16_t>* transitions) {
  const uint64_t* row = bits.row(y);
  uint64_t previous = 0;
  for (int word = 0; word < bits.words; ++word) {
    uint64_t change = row[word] ^ ((row[word] << 1) | previous);
    previous = row[word] >> 63;
    for (; change != 0; change &= change - 1) {
      transitions->push_back(static_cast<uint16_t>(word * 64 + __builtin_ctzll(change)));
    }
  }
  // White up to the last bit of the last word: the outside begins right after it.
  if (previous != 0) transitions->push_back(static_cast<uint16_t>(bits.words * 64));
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

// The runs of one row: `count` transitions t, count + 1 labels.
struct Row {
  const uint16_t* transition;
  int count;
  uint32_t* label;

  int begin(int run) const { return run == 0 ? -1 : transition[run - 1]; }
  int end(int run) const { return run == count ? INT32_MAX : transition[run]; }
};

// Joins each run with the runs of its colour above that it touches: white ones by an edge, black
// ones by an edge or a corner. A run that touches none starts a component.
void LabelRow(const Row& above, const Row& row, LabelWorkspace* ws) {
  int first[2] = {0, 1};  // by colour, the first run above that may still be touched
  row.label[0] = 0;
  for (int run = 0; run <= row.count; ++run) {
    const int white = run & 1;
    const int reach = white ? 0 : 1;
    const int begin = row.begin(run) - reach;
    const int end = row.end(run) == INT32_MAX ? INT32_MAX : row.end(run) + reach;
    int& touched = first[white];
    while (touched <= above.count && above.end(touched) <= begin) touched += 2;
    const bool outside = run == 0 || run == row.count;
    bool found = outside;
    uint32_t label = 0;
    for (int i = touched; i <= above.count && above.begin(i) < end; i += 2) {
      label = found ? Unite(ws->root, label, above.label[i]) : FindRoot(ws->root, above.label[i]);
      found = true;
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
  components->parent.clear();
  components->white.clear();
  std::vector<uint32_t>& number = ws->root;
  for (size_t label = 0; label < number.size(); ++label) {
    if (number[label] != label) {
      number[label] = number[number[label]];  // its root is smaller: numbered already
      continue;
    }
    number[label] = static_cast<uint32_t>(components->parent.size());
    const uint32_t parent = number[ws->parent[label]];
    components->parent.push_back(parent);
    components->white.push_back(label == 0 ? 0 : !components->white[parent]);
  }
  for (uint32_t& label : components->label) label = number[label];
}

}  // namespace

void Label(const BitImage& bits, LabelWorkspace* workspace, Components* components) {
  components->width = bits.width;
  components->height = bits.height;
  components->row_begin.clear();
  components->transition.clear();
  for (int y = 0; y < bits.height; ++y) {
    components->row_begin.push_back(static_cast<uint32_t>(components->transition.size()));
    AppendTransitions(bits, y, &components->transition);
  }
  components->row_begin.push_back(static_cast<uint32_t>(components->transition.size()));
  components->label.resize(components->transition.size() + static_cast<size_t>(bits.height));

  workspace->root.assign(1, 0);
  workspace->parent.assign(1, 0);
  uint32_t outside = 0;
  Row above{nullptr, 0, &outside};
  for (int y = 0; y < bits.height; ++y) {
    const uint32_t begin = components->row_begin[static_cast<size_t>(y)];
    const uint32_t end = components->row_begin[static_cast<size_t>(y) + 1];
    const Row row{components->transition.data() + begin, static_cast<int>(end - begin),
                  components->label.data() + components->run_begin(y)};
    LabelRow(above, row, workspace);
    above = row;
  }
  // Black runs of the last row touch the outside below it.
  for (int run = 0; run <= above.count; run += 2) Unite(workspace->root, 0, above.label[run]);
  Renumber(workspace, components);
}

void Measure(const Components& components, const std::vector<uint32_t>& slot,
             std::vector<Feature>* features) {
  for (int y = 0; y < components.height; ++y) {
    const uint32_t* label = components.label.data() + components.run_begin(y);
    const uint16_t* transition =
        components.transition.data() + components.row_begin[static_cast<size_t>(y)];
    const int count = static_cast<int>(components.row_begin[static_cast<size_t>(y) + 1] -
                                       components.row_begin[static_cast<size_t>(y)]);
    for (int run = 0; run <= count; ++run) {
      const uint32_t s = slot[label[run]];
      if (s == 0) continue;
      const int begin = run == 0 ? 0 : transition[run - 1];
      const int end = run == count ? components.width : transition[run];
      if (begin >= end) continue;
      const int length = end - begin;
      Feature& feature = (*features)[s];
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
