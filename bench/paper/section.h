#ifndef TOPOTAG_BENCH_PAPER_SECTION_H_
#define TOPOTAG_BENCH_PAPER_SECTION_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "topotag/geometry.h"
#include "topotag/image.h"

namespace topotag::bench::paper {

using Json = nlohmann::ordered_json;

/// Whose figures a row has.
enum class Who {
  kPaper,  ///< published: TopoTag's and its peers', as in the paper
  kOurs,   ///< measured here
  kPeer,   ///< measured here
};

/// "paper", "ours", "peer".
const char* Name(Who who);

struct Cell {
  std::string text;             ///< plain text; "" = the system has no such figure
  std::optional<double> value;  ///< what is compared; without it the cell is left out of that
};

/// `value` with so many decimals.
Cell Number(double value, int decimals);
/// "99.5 %" of part / all; "none" without any.
Cell Percent(int part, int all);
/// What the sources that were read do not say.
Cell NotGiven();

/// Which of two values is better.
enum class Better { kNeither, kLower, kHigher };

struct Column {
  std::string title;  ///< with its unit
  Better better = Better::kNeither;
};

/// One system's figures, one cell a column.
struct Row {
  Who who = Who::kOurs;
  std::string name;
  std::vector<Cell> cells{};
};

struct Table {
  std::string id;  ///< unique on the page: "recall"
  std::string title;
  std::vector<Column> columns{};
  std::vector<Row> rows{};
  std::string note{};  ///< how to read it, or ""
};

/// Columns in which a peer measured here is better than rows of ours.
struct Ahead {
  std::string text;     ///< a sentence with the columns and the figures
  bool of_all = false;  ///< better than all of ours, else than some of them
};

/// Worked out from the values of the cells; up to two for each peer.
std::vector<Ahead> PeersAhead(const Table& table);

/// A part of an example frame.
struct Picture {
  std::string caption;
  Image pixels;
};

/// A rectangle of a frame, cut off at its borders.
Image Crop(const ImageView& frame, const Rect& part);

struct Section {
  std::string id;  ///< as in --sections
  std::string title;
  std::vector<std::string> paragraphs{};  ///< plain text, before the tables
  std::vector<Table> tables{};
  std::vector<std::string> plots{};  ///< of bench/svg.h, in cards (bench/html.h)
  std::vector<Picture> pictures{};
  Json data = Json::object();  ///< for the JSON, beside the tables
  /// What ours promise and did not keep, such as a missed frame, with what is needed to repeat it:
  /// the command reports them and fails.
  std::vector<std::string> broken{};
};

}  // namespace topotag::bench::paper

#endif  // TOPOTAG_BENCH_PAPER_SECTION_H_
