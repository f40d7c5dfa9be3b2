#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "host/file.h"
#include "tools/command.h"
#include "tools/output.h"
#include "topotag/error.h"
#include "topotag/generator.h"

namespace topotag::tools {
namespace {

namespace fs = std::filesystem;

/// The command line as it was typed.
struct Arguments {
  std::string family;
  std::string id;
  std::string ids;
  std::string inner = "square";
  std::string outer = "square";
  std::string frame = "1";
  std::string margin = "0";
  bool inverted = false;
  std::string size_mm = "50";
  std::string dpi = "300";
  std::string page;
  std::string format;
  std::string output;
};

MarkerDesign ParseDesign(const Arguments& arguments) {
  MarkerDesign design;
  design.family = ForOption("--family", [&] { return Family::Parse(arguments.family); });
  design.inner = ForOption("--inner", [&] { return ParseInnerShape(arguments.inner); });
  ForOption("--outer", [&] {
    SetOuterShape(arguments.outer, &design);
    return 0;
  });
  design.frame = ParseNotNegative("--frame", arguments.frame);
  design.margin = ParseNotNegative("--margin", arguments.margin);
  design.inverted = arguments.inverted;
  return design;
}

bool IsFolder(const std::string& output) {
  std::error_code ignored;
  return output.back() == '/' || fs::is_directory(output, ignored);
}

SheetOptions ParsePage(const std::string& page) {
  SheetOptions sheet;
  if (page.empty() || page == "a4") return sheet;
  CheckChoice("--page", page, {"a4", "letter"});
  sheet.page_width_mm = 215.9;
  sheet.page_height_mm = 279.4;
  return sheet;
}

/// FAMILY_ID with as many digits as the family's last ID.
std::string FileName(const MarkerDesign& design, const std::string& format) {
  const size_t digits = std::to_string(design.family.size() - 1).size();
  const std::string id = std::to_string(design.id);
  return design.family.name() + "_" + std::string(digits - id.size(), '0') + id + "." + format;
}

/// Of the errors of `write`, those that are not about the file do not name it.
template <typename Write>
void WriteTo(const std::string& file, Write write) {
  try {
    write();
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kInvalidArgument) throw;
    throw Error(error.code(), Named(file, error.what()));
  }
}

void WriteFolder(const Arguments& arguments, MarkerDesign design, const PrintOptions& print,
                 const std::vector<uint64_t>& ids) {
  const std::string format = arguments.format.empty() ? "png" : arguments.format;
  MakeFolder(arguments.output);
  for (const uint64_t id : ids) {
    design.id = id;
    const std::string file = (fs::path(arguments.output) / FileName(design, format)).string();
    WriteTo(file, [&] { WriteMarker(design, print, file); });
  }
}

void CheckOutputFile(const Arguments& arguments) {
  CheckOutputs({{"-o", arguments.output}}, {arguments.outer});
  const std::string extension = LowerExtension(arguments.output);
  if (extension != ".png" && extension != ".svg" && extension != ".pdf") {
    throw UsageError("-o: '" + arguments.output +
                     "' does not end in .png, .svg or .pdf and is not a folder");
  }
  if (!arguments.format.empty() && "." + arguments.format != extension) {
    throw UsageError("--format: " + arguments.format + " contradicts the file's name " +
                     arguments.output);
  }
}

void Generate(const Arguments& arguments) {
  MarkerDesign design = ParseDesign(arguments);
  PrintOptions print;
  print.size_mm = ParsePositive("--size-mm", arguments.size_mm);
  print.dpi = ParsePositive("--dpi", arguments.dpi);
  if (arguments.id.empty() == arguments.ids.empty()) {
    throw UsageError("--id: give either --id or --ids");
  }
  const bool is_single = arguments.ids.empty();
  const std::vector<uint64_t> ids =
      is_single ? std::vector<uint64_t>{ParseId("--id", arguments.id, design.family)}
                : ParseIds("--ids", arguments.ids, design.family);
  const SheetOptions sheet = ParsePage(arguments.page);
  if (!arguments.format.empty()) CheckChoice("--format", arguments.format, {"png", "svg", "pdf"});
  const bool is_folder = IsFolder(arguments.output);
  if (!arguments.page.empty() && (is_single || is_folder)) {
    throw UsageError("--page: applies to a sheet: --ids with a file");
  }
  if (is_folder) {
    WriteFolder(arguments, design, print, ids);
    return;
  }
  CheckOutputFile(arguments);
  if (is_single) {
    design.id = ids[0];
    WriteTo(arguments.output, [&] { WriteMarker(design, print, arguments.output); });
    return;
  }
  std::vector<MarkerDesign> designs(ids.size(), design);
  for (size_t i = 0; i < ids.size(); ++i) designs[i].id = ids[i];
  WriteTo(arguments.output, [&] { WriteSheet(designs, print, sheet, arguments.output); });
}

int RunGenerate(const Arguments& arguments) {
  try {
    Generate(arguments);
    return kSuccess;
  } catch (const Error& error) {
    // What cannot be drawn or does not fit the page was asked for in the options.
    if (error.code() == ErrorCode::kInvalidArgument) throw UsageError(error.what());
    throw;
  }
}

}  // namespace

Command AddGenerate(CLI::App* app) {
  CLI::App* command = app->add_subcommand("generate", "Write markers to print: PNG, SVG or PDF");
  const auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  AddText(command, "Marker", "--family", &a.family, "NAME", "Family: 3x3 .. 8x8")->required();
  AddText(command, "Marker", "--id", &a.id, "N", "ID of one marker");
  AddText(command, "Marker", "--ids", &a.ids, "LIST", "IDs of many markers: 0-99 or 1,5,7-9");
  AddText(command, "Marker", "--inner", &a.inner, "SHAPE",
          "Nodes: square (default), circle or hexagon");
  AddText(command, "Marker", "--outer", &a.outer, "SHAPE",
          "White area: square (default), circle, butterfly or a file with a polygon, "
          "one \"x y\" in units a line");
  AddText(command, "Marker", "--frame", &a.frame, "UNITS", "Width of the black frame (default: 1)");
  AddText(command, "Marker", "--margin", &a.margin, "UNITS",
          "Width of the white paper around it (default: 0)");
  command->add_flag("--inverted", a.inverted, "White and black exchanged")->group("Marker");
  AddText(command, "Print", "--size-mm", &a.size_mm, "MM", "Side of the white area (default: 50)");
  AddText(command, "Print", "--dpi", &a.dpi, "DPI", "Pixels an inch in a PNG (default: 300)");
  AddText(command, "Print", "--page", &a.page, "NAME", "Page of a sheet: a4 (default) or letter");
  AddText(command, "Output", "-o,--output", &a.output, "FILE",
          "FILE.png, FILE.svg or FILE.pdf: one marker, or a sheet of --ids; DIR/: a file a "
          "marker, FAMILY_ID.png")
      ->required();
  AddText(command, "Output", "--format", &a.format, "NAME",
          "Files in a folder: png (default), svg or pdf");
  command->footer(
      "A unit is the side of the white area / (4n+1) for an n x n family.\n"
      "Examples:\n"
      "  topotag generate --family 4x4 --id 278 -o marker.pdf\n"
      "  topotag generate --family 3x3 --ids 0-19 --size-mm 40 -o sheet.pdf\n"
      "  topotag generate --family 5x5 --ids 0-99 --inner circle --format svg -o tags/");
  return [arguments] { return RunGenerate(*arguments); };
}

}  // namespace topotag::tools
