#ifndef TOPOTAG_TOOLS_HELP_H_
#define TOPOTAG_TOOLS_HELP_H_

#include <CLI/CLI.hpp>
#include <string>

namespace topotag::tools {

/// The layout of --help, for a terminal of 80 columns: long explanations are wrapped, and one
/// blank line stands between groups of options.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter();
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
};

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_HELP_H_
