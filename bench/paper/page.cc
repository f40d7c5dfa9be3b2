#include "bench/paper/page.h"

#include <cmath>

#include "bench/html.h"
#include "bench/paper/png_uri.h"
#include "bench/paper/published.h"

namespace topotag::bench::paper {
namespace {

constexpr char kPaperStyle[] = R"(<style>
td.who, th.who { text-align: left; color: #7b8794; padding-right: 4px; }
td.name, th.name { text-align: left; }
tr.paper td { color: #52606d; font-style: italic; background: #fafbfc; }
tr.ours td { background: #eef6f0; } tr.ours td.who { color: #2f7d48; font-weight: 600; }
td.best { font-weight: 700; }
tr.first td { border-top: 2px solid #cbd2d9; }
th { vertical-align: bottom; white-space: normal; min-width: 56px; }
th.name { min-width: 130px; }
h3.table { margin: 18px 0 4px; } p.note { font-size: 13px; color: #52606d; margin: 6px 0 4px; }
ul.ahead { font-size: 13px; margin: 4px 0 12px; padding-left: 20px; }
.pictures { display: flex; flex-wrap: wrap; gap: 12px; margin: 12px 0; }
figure { margin: 0; background: #fff; border: 1px solid #dde3ea; border-radius: 6px; padding: 8px; }
figure img { display: block; height: 190px; max-width: 400px; object-fit: contain; }
figcaption { font-size: 12px; color: #52606d; margin-top: 4px; max-width: 300px; }
.contents a { margin-right: 14px; } .failed { color: #c4272b; }
</style>
)";

std::string Tagged(const std::string& tag, const std::string& content, const std::string& css) {
  const std::string open = css.empty() ? tag : tag + " class='" + css + "'";
  return "<" + open + ">" + content + "</" + tag + ">";
}

/// Whether a cell has the best of all measured values in its column, and not all are the same.
bool IsBest(const Table& table, const Row& row, size_t column) {
  const Better better = table.columns[column].better;
  if (better == Better::kNeither || row.who == Who::kPaper || !row.cells[column].value) {
    return false;
  }
  const double own = *row.cells[column].value;
  bool any_worse = false;
  for (const Row& other : table.rows) {
    if (other.who == Who::kPaper || column >= other.cells.size() || !other.cells[column].value) {
      continue;
    }
    const double value = *other.cells[column].value;
    if (better == Better::kLower ? value < own : value > own) return false;
    any_worse = any_worse || value != own;
  }
  return any_worse;
}

std::string TableHtml(const Table& table) {
  std::string html = "<h3 class='table' id='" + table.id + "'>" + Escape(table.title) + "</h3>\n";
  html += "<div class='card'><table><tr>" + Tagged("th", "", "who") + Tagged("th", "", "name");
  for (const Column& column : table.columns) html += Tagged("th", Escape(column.title), "");
  html += "</tr>\n";
  const Row* previous = nullptr;
  for (const Row& row : table.rows) {
    const bool first = previous == nullptr || previous->who != row.who;
    previous = &row;
    html += std::string("<tr class='") + Name(row.who) + (first ? " first" : "") + "'>";
    html += Tagged("td", Name(row.who), "who") + Tagged("td", Escape(row.name), "name");
    for (size_t column = 0; column < row.cells.size(); ++column) {
      html +=
          Tagged("td", Escape(row.cells[column].text), IsBest(table, row, column) ? "best" : "");
    }
    html += "</tr>\n";
  }
  html += "</table></div>\n";
  if (!table.note.empty()) html += Tagged("p", Escape(table.note), "note") + "\n";
  return html;
}

std::string AheadHtml(const Table& table) {
  std::string all, some;
  for (const Ahead& ahead : PeersAhead(table)) {
    (ahead.of_all ? all : some) += Tagged("li", Escape(ahead.text), "") + "\n";
  }
  std::string html;
  if (!all.empty()) {
    html += "<p class='note'><b>Where a peer is ahead of all of ours</b></p>\n" +
            Tagged("ul", all, "ahead");
  }
  if (!some.empty()) {
    html += Details("Where a peer is ahead of some of ours, but not of the best",
                    Tagged("ul", some, "ahead"));
  }
  return html;
}

std::string PicturesHtml(const std::vector<Picture>& pictures) {
  if (pictures.empty()) return "";
  std::string html;
  for (const Picture& picture : pictures) {
    html += "<figure><img src='" + PngUri(picture.pixels.view()) + "' alt='" +
            Escape(picture.caption) + "'>" + Tagged("figcaption", Escape(picture.caption), "") +
            "</figure>\n";
  }
  return "<div class='pictures'>" + html + "</div>\n";
}

std::string SectionHtml(const Section& section) {
  std::string html = "<h2 id='section-" + section.id + "'>" + Escape(section.title) + "</h2>\n";
  for (const std::string& text : section.paragraphs) {
    html += Tagged("p", Escape(text), "") + "\n";
  }
  for (const std::string& text : section.broken) {
    html += Tagged("p", "Not kept: " + Escape(text), "failed") + "\n";
  }
  for (const Table& table : section.tables) html += TableHtml(table) + AheadHtml(table);
  std::string plots;
  for (const std::string& plot : section.plots) plots += plot;
  if (!plots.empty()) html += Grid(plots);
  return html + PicturesHtml(section.pictures);
}

/// Of the whole page: where a peer is ahead of all of ours.
std::string Summary(const std::vector<Section>& sections) {
  std::string items;
  for (const Section& section : sections) {
    for (const Table& table : section.tables) {
      for (const Ahead& ahead : PeersAhead(table)) {
        if (!ahead.of_all) continue;
        items += "<li><a href='#" + table.id + "'>" + Escape(table.title) + "</a>. " +
                 Escape(ahead.text) + "</li>\n";
      }
    }
  }
  if (items.empty()) return "<p>In no column of any table is a peer ahead of all of ours.</p>\n";
  return "<p>Where a peer is ahead of all of ours, worked out from the tables:</p>\n" +
         Tagged("ul", items, "ahead") + "\n";
}

std::string Facts(const RunFacts& facts) {
  std::vector<Strings> rows;
  for (const auto& item : facts.machine.items()) {
    const Json& value = item.value();
    rows.push_back(
        {Escape(item.key()), Escape(value.is_string() ? value.get<std::string>() : value.dump())});
  }
  rows.push_back({"backgrounds", Escape(facts.backgrounds)});
  rows.push_back({"time of the run", std::to_string(std::lround(facts.seconds)) + " s"});
  for (const std::string& system : facts.systems) rows.push_back({"system", Escape(system)});
  for (const std::string& reason : facts.missing) rows.push_back({"missing", Escape(reason)});
  return Details("Machine and systems", bench::Table({"", ""}, rows, "text"));
}

Json TableJson(const Table& table) {
  Json json{{"id", table.id}, {"title", table.title}, {"columns", Json::array()}};
  for (const Column& column : table.columns) json["columns"].push_back(column.title);
  json["rows"] = Json::array();
  for (const Row& row : table.rows) {
    Json cells = Json::array();
    for (const Cell& cell : row.cells) {
      cells.push_back(cell.value ? Json(*cell.value) : Json(cell.text));
    }
    json["rows"].push_back({{"who", Name(row.who)}, {"name", row.name}, {"cells", cells}});
  }
  json["note"] = table.note;
  json["peers_ahead"] = Json::array();
  for (const Ahead& ahead : PeersAhead(table)) {
    json["peers_ahead"].push_back({{"text", ahead.text}, {"of_all", ahead.of_all}});
  }
  return json;
}

}  // namespace

std::string MakePage(const RunFacts& facts, const std::vector<Section>& sections) {
  std::string content = kPaperStyle;
  content +=
      "<p>The tables of the paper (Yu, Hu, Dai, TopoTag, IEEE TVCG 2021) on rendered frames, "
      "beside "
      "AprilTag 3 and OpenCV's ArUco in the same poses. Every marker, with the one cell of border "
      "that belongs to it, has a side of 5 cm; the camera has 1280 x 960 pixels and sees 98 "
      "degrees "
      "across its diagonal. Rows: <i>paper</i> as published, <b>ours</b> and peers as measured by "
      "this run; the best measured figure of a column is bold.</p>\n";
  content += Tagged("p", Escape(kRobotArm), "") + "\n";
  content +=
      "<p>ArUco needs a second white cell before dark surroundings, which it gets outside the 5 "
      "cm. "
      "The paper's data set is not to be had: trajectories are this program's, in the paper's "
      "spirit.</p>\n";
  if (facts.quick) {
    content +=
        "<p class='failed'>Quick run: a few frames of everything, figures mean little.</p>\n";
  }
  content += "<p class='contents'>";
  for (const Section& section : sections) {
    content += "<a href='#section-" + section.id + "'>" + Escape(section.title) + "</a> ";
  }
  content += "</p>\n" + Summary(sections) + Facts(facts);
  for (const Section& section : sections) content += SectionHtml(section);
  return Document("TopoTag: the paper's tables", content);
}

Json MakeJson(const RunFacts& facts, const std::vector<Section>& sections) {
  Json json{{"machine", facts.machine},         {"quick", facts.quick},
            {"backgrounds", facts.backgrounds}, {"seconds", facts.seconds},
            {"systems", facts.systems},         {"missing", facts.missing},
            {"sections", Json::array()}};
  for (const Section& section : sections) {
    Json tables = Json::array();
    for (const Table& table : section.tables) tables.push_back(TableJson(table));
    json["sections"].push_back({{"id", section.id},
                                {"title", section.title},
                                {"paragraphs", section.paragraphs},
                                {"tables", tables},
                                {"data", section.data},
                                {"broken", section.broken}});
  }
  return json;
}

}  // namespace topotag::bench::paper
