#include "bench/html.h"

namespace topotag::bench {
namespace {

constexpr char kStyle[] = R"(
body { font: 15px/1.5 system-ui, sans-serif; color: #1f2933; background: #f5f7fa; margin: 0; }
main { max-width: 1100px; margin: 0 auto; padding: 24px; }
h1 { margin: 0 0 4px; font-size: 26px; } h2 { margin: 36px 0 6px; font-size: 20px; }
h3 { margin: 0 0 6px; font-size: 15px; } p { margin: 4px 0 10px; max-width: 820px; }
.grid { display: grid; grid-template-columns: repeat(auto-fit, minmax(500px, 1fr)); gap: 16px; }
.card { background: #fff; border: 1px solid #dde3ea; border-radius: 6px; padding: 12px 14px;
  overflow-x: auto; }
svg { max-width: 100%; height: auto; display: block; }
svg text { font: 11px system-ui, sans-serif; fill: #3e4c59; } svg .title { font-weight: 600; }
svg .rule { stroke: #e4e9ef; } svg .axis { stroke: #7b8794; }
.legend { display: flex; flex-wrap: wrap; gap: 2px 16px; margin: 2px 0 10px; font-size: 13px; }
.legend i { display: inline-block; width: 12px; height: 12px; margin-right: 5px;
  border-radius: 2px; vertical-align: -1px; }
table { border-collapse: collapse; font-size: 13px; background: #fff; }
th, td { border-bottom: 1px solid #e4e9ef; padding: 3px 10px; text-align: right;
  white-space: nowrap; }
th:first-child, td:first-child { text-align: left; } th { color: #52606d; }
table.text td { text-align: left; white-space: normal; }
.bad { color: #c4272b; font-weight: 600; } details { margin: 10px 0; }
summary { cursor: pointer; font-weight: 600; }
)";

std::string Row(const Strings& cells, const char* tag = "td") {
  std::string row = "<tr>";
  for (const std::string& cell : cells) {
    row += std::string("<") + tag + ">" + cell + "</" + tag + ">";
  }
  return row + "</tr>\n";
}

}  // namespace

std::string Escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '\'':
        out += "&#39;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string Table(const Strings& head, const std::vector<Strings>& rows, const char* css) {
  std::string table =
      std::string("<div class='card'><table class='") + css + "'>" + Row(head, "th");
  for (const Strings& row : rows) table += Row(row);
  return table + "</table></div>\n";
}

std::string Details(const std::string& title, const std::string& content, bool open) {
  return std::string("<details") + (open ? " open" : "") + "><summary>" + Escape(title) +
         "</summary>\n" + content + "</details>\n";
}

std::string Card(const std::string& title, const std::string& content) {
  return "<div class='card'><h3>" + Escape(title) + "</h3>" + content + "</div>\n";
}

std::string Grid(const std::string& cards) { return "<div class='grid'>" + cards + "</div>\n"; }

std::string Document(const std::string& title, const std::string& content) {
  return "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
         "<meta name='viewport' content='width=device-width'><title>" +
         Escape(title) + "</title><style>" + kStyle + "</style></head><body><main>\n<h1>" +
         Escape(title) + "</h1>\n" + content + "</main></body></html>\n";
}

}  // namespace topotag::bench
