#ifndef TOPOTAG_BENCH_HTML_H_
#define TOPOTAG_BENCH_HTML_H_

#include <string>
#include <vector>

namespace topotag::bench {

using Strings = std::vector<std::string>;

/// With the characters replaced that mean something in HTML.
std::string Escape(const std::string& text);

/// Pieces of a page. Titles are text; everything else is HTML.
/// @param css  class: "text" for a table that is not of numbers.
std::string Table(const Strings& head, const std::vector<Strings>& rows, const char* css = "");
std::string Details(const std::string& title, const std::string& content, bool open = false);
std::string Card(const std::string& title, const std::string& content);
std::string Grid(const std::string& cards);

/// A whole page with its style, which needs no other file.
std::string Document(const std::string& title, const std::string& content);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_HTML_H_
