#pragma once

#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace hpdm {

/// Ends a command whose check failed. main() exits with `exit_code` and prints nothing more.
struct CheckFailed {
  int exit_code = 1;
};

/// One option or positional argument of a command. A handle: copies refer to the same option.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option Required();
  Option ShowDefault();                 ///< Shows the default in the help text.
  Option From(double min, double max);  ///< Accepts only numbers in [min, max].
  Option OneOf(
      const std::vector<std::string>& words);  ///< Accepts only these; the help lists them.
  Option OneOfUnlisted(const std::vector<std::string>& words);  ///< As OneOf, not in the help.
  Option SplitAt(char separator);                       ///< Takes several values in one argument.
  Option OneValueEach();                                ///< Repeatable, with one value each time.
  Option OptionalValue(const std::string& value_name);  ///< May be given without a value.
  Option Needs(const Option& other);
  Option Excludes(const Option& other);
  Option Excludes(const std::string& other);
  bool Given() const;  ///< True if the command line had it. Call after parsing.

 private:
  CLI::Option* option_;
};

/// A command or subcommand. A handle, valid during RunCommandLine.
///
/// Options are bound to values, which must outlive parsing. A value keeps its default unless the
/// command line has the option.
///
/// CLI11 does the work. Only command_line.cc includes it: its header takes seconds to compile.
class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}

  Command AddCommand(const std::string& name, const std::string& help) const;
  void RequireCommand() const;  ///< Requires one of the subcommands.
  /// Adds a flag that sets `value` to true. A `name` "!--no-x" sets it to false.
  Option AddFlag(const std::string& name, bool& value, const std::string& help) const;
  /// Adds an option; `name` without dashes is a positional argument. `Value` is one of the types
  /// instantiated in command_line.cc.
  template <typename Value>
  Option AddOption(const std::string& name, Value& value, const std::string& help) const;
  /// Calls `run` while the command line is parsed, if it names this command.
  void OnRun(std::function<void()> run) const;

 private:
  CLI::App* app_;
};

/// Parses `arguments` (without the program's name) with the commands that `add` adds and runs the
/// one that is named. Returns the exit code: 0, or that of CheckFailed. Prints help and version.
/// Throws InputError for a wrong command line; exceptions of the command pass through.
int RunCommandLine(const std::string& program, const std::string& about, const std::string& version,
                   std::vector<std::string> arguments, const std::function<void(Command)>& add);

}  // namespace hpdm
