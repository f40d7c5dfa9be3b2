#include "bench/paper/section.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace topotag::bench::paper {
namespace {

bool IsBetter(double a, double b, Better better) {
  return better == Better::kLower ? a < b : better == Better::kHigher && a > b;
}

std::string Quoted(const Row& row, size_t column) {
  return row.name + " " + row.cells[column].text;
}

/// Rows of `who` with a value in this column.
std::vector<const Row*> RowsWithValue(const Table& table, Who who, size_t column) {
  std::vector<const Row*> rows;
  for (const Row& row : table.rows) {
    if (row.who == who && column < row.cells.size() && row.cells[column].value) {
      rows.push_back(&row);
    }
  }
  return rows;
}

/// What a peer's sentences say of one column: "title (0.1; TopoTag 4x4 0.2)", or "".
struct ColumnAhead {
  std::string of_all, of_some;
};

ColumnAhead AheadIn(const Table& table, const Row& peer, size_t column) {
  const Better better = table.columns[column].better;
  if (better == Better::kNeither || column >= peer.cells.size() || !peer.cells[column].value) {
    return {};
  }
  const double value = *peer.cells[column].value;
  const std::vector<const Row*> ours = RowsWithValue(table, Who::kOurs, column);
  const Row* best = nullptr;
  std::string beaten;
  size_t count = 0;
  for (const Row* row : ours) {
    const double own = *row->cells[column].value;
    if (best == nullptr || IsBetter(own, *best->cells[column].value, better)) best = row;
    if (!IsBetter(value, own, better)) continue;
    beaten += (count++ == 0 ? "" : ", ") + Quoted(*row, column);
  }
  if (count == 0) return {};
  const std::string start = table.columns[column].title + " (" + peer.cells[column].text + "; ";
  if (count == ours.size()) return {start + "the best of ours " + Quoted(*best, column) + ")", ""};
  return {"", start + beaten + ")"};
}

void Append(const std::string& item, std::string* list) {
  if (!item.empty()) *list += (list->empty() ? "" : "; ") + item;
}

}  // namespace

const char* Name(Who who) {
  return who == Who::kPaper ? "paper" : who == Who::kOurs ? "ours" : "peer";
}

Cell Number(double value, int decimals) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return {text, value};
}

Cell Percent(int part, int all) {
  if (all == 0) return {"none", std::nullopt};
  const double share = 100.0 * part / all;
  char text[32];
  // 100 only where it is all of them.
  const double shown = part == all ? 100 : std::min(share, 99.99);
  std::snprintf(text, sizeof text, part == all || part == 0 ? "%.0f %%" : "%.2f %%", shown);
  return {text, share};
}

Cell NotGiven() { return {"not given", std::nullopt}; }

std::vector<Ahead> PeersAhead(const Table& table) {
  std::vector<Ahead> ahead;
  for (const Row& row : table.rows) {
    if (row.who != Who::kPeer) continue;
    std::string of_all, of_some;
    for (size_t column = 0; column < table.columns.size(); ++column) {
      const ColumnAhead here = AheadIn(table, row, column);
      Append(here.of_all, &of_all);
      Append(here.of_some, &of_some);
    }
    if (!of_all.empty()) {
      ahead.push_back({row.name + " is ahead of all of ours in: " + of_all + ".", true});
    }
    if (!of_some.empty()) {
      ahead.push_back({row.name + " is ahead of some of ours in: " + of_some + ".", false});
    }
  }
  return ahead;
}

Image Crop(const ImageView& frame, const Rect& part) {
  const int x0 = std::max(0, part.x), x1 = std::min(frame.width, part.x + part.width);
  const int y0 = std::max(0, part.y), y1 = std::min(frame.height, part.y + part.height);
  Image crop(x1 - x0, y1 - y0);
  for (int y = y0; y < y1; ++y) {
    std::memcpy(crop.row(y - y0), frame.row(y) + x0, static_cast<size_t>(x1 - x0));
  }
  return crop;
}

}  // namespace topotag::bench::paper
