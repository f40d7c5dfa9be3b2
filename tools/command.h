#ifndef TOPOTAG_TOOLS_COMMAND_H_
#define TOPOTAG_TOOLS_COMMAND_H_

#include <cstdint>
#include <exception>
#include <functional>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/one_line.h"
#include "topotag/error.h"
#include "topotag/family.h"
#include "topotag/marker.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace topotag::tools {

enum ExitStatus : int {
  kSuccess = 0,   ///< everything was processed, also when nothing was found
  kFailure = 1,   ///< an input could not be read or an output could not be written
  kUsage = 2,     ///< wrong usage
  kSignal = 128,  ///< plus its number: ended by a signal, as shells have it
};

/// Wrong usage: one line that names the option and the reason.
class UsageError : public std::runtime_error {
 public:
  explicit UsageError(const std::string& message) : std::runtime_error(OneLine(message)) {}
};

/// Each adds its subcommand with its options and returns what to run once they are parsed.
using Command = std::function<int()>;
Command AddDetect(CLI::App* app);
Command AddGenerate(CLI::App* app);
Command AddRender(CLI::App* app);
Command AddBench(CLI::App* app);
Command AddInfo(CLI::App* app);
Command AddObject(CLI::App* app);

/// The arguments that name what to read: at least one, none of them empty.
CLI::Option* AddInputs(CLI::App* command, const char* name, std::vector<std::string>* inputs,
                       const char* help);

/// An option whose value is kept as it is typed; an empty value is wrong usage.
CLI::Option* AddText(CLI::App* command, const char* group, const char* name, std::string* value,
                     const char* type, const char* help);

/// Values of options; each throws UsageError "OPTION: reason".
double ParseNumber(const std::string& option, const std::string& text);
double ParsePositive(const std::string& option, const std::string& text);
double ParseNotNegative(const std::string& option, const std::string& text);
uint64_t ParseUnsigned(const std::string& option, const std::string& text);
std::vector<double> ParseNumbers(const std::string& option, const std::string& text, size_t count);
/// IDs of a family: "1,5,7-9".
std::vector<uint64_t> ParseIds(const std::string& option, const std::string& text, Family family);
void CheckChoice(const std::string& option, const std::string& value,
                 std::initializer_list<const char*> choices);

/// Runs `parse` and turns a topotag::Error into a UsageError that names the option.
template <typename Parse>
auto ForOption(const std::string& option, Parse parse) {
  try {
    return parse();
  } catch (const std::exception& error) {
    throw UsageError(option + ": " + error.what());
  }
}

/// "SUBJECT: message", without naming the subject twice.
std::string Named(const std::string& subject, const std::string& message);

/// Runs `use` and makes a topotag::Error begin with the file's name.
template <typename Use>
auto ForFile(const std::string& file, Use use) {
  try {
    return use();
  } catch (const Error& error) {
    throw Error(error.code(), Named(file, error.what()));
  }
}

/// Sets the outer shape from a shape's name. @return whether it is one
bool SetNamedOuterShape(const std::string& name, MarkerDesign* design);
/// Sets the outer shape from a shape's name or from a file with a polygon.
/// @throws Error (kInvalidArgument: neither a name nor a file; kFile, kParse: ReadPolygon's).
void SetOuterShape(const std::string& name_or_file, MarkerDesign* design);

/// The ID of an option's value. @throws UsageError
uint64_t ParseId(const std::string& option, const std::string& text, Family family);

/// An ID of the family. @throws Error (kInvalidArgument) that names the family's range.
void CheckId(Family family, uint64_t id);

/// What an exception says; where memory has run out, these words.
std::string Describe(const std::exception& error);

/// Prints "topotag: MESSAGE" as one line on stderr.
void Complain(const std::string& message);

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_COMMAND_H_
