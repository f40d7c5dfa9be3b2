#include "tools/help.h"

#include <utility>

namespace topotag::tools {
namespace {

constexpr size_t kWidth = 80;
constexpr size_t kNameWidth = 26;

}  // namespace

HelpFormatter::HelpFormatter() { column_width(kNameWidth); }

std::string HelpFormatter::make_help(const CLI::App* app, std::string name,
                                     CLI::AppFormatMode mode) const {
  const std::string help = CLI::Formatter::make_help(app, std::move(name), mode);
  return CLI::detail::find_and_replace(help, "\n\n\n", "\n\n");
}

std::string HelpFormatter::make_option_desc(const CLI::Option* option) const {
  std::string text = option->get_description();
  for (size_t begin = 0; text.size() - begin > kWidth - kNameWidth;) {
    const size_t space = text.rfind(' ', begin + kWidth - kNameWidth);
    if (space == std::string::npos || space <= begin) break;
    text[space] = '\n';
    begin = space + 1;
  }
  return text;
}

}  // namespace topotag::tools
