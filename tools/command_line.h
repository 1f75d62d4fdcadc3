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

/// One option or positional argument of a command. A handle: copies are the same option.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option Required();
  Option ShowDefault();                                 ///< In the help text.
  Option From(double min, double max);                  ///< Takes numbers in [min, max] only.
  Option OneOf(const std::vector<std::string>& words);  ///< Takes these only; the help lists them.
  Option OneOfUnlisted(const std::vector<std::string>& words);  ///< The same, not in the help.
  Option SplitAt(char separator);                               ///< Several values in one argument.
  Option OneValueEach();                                ///< Repeatable, one value each time.
  Option OptionalValue(const std::string& value_name);  ///< May stand without a value.
  Option Needs(const Option& other);
  Option Excludes(const Option& other);
  Option Excludes(const std::string& other);
  bool Given() const;  ///< True if the command line had it. After parsing.

 private:
  CLI::Option* option_;
};

/// A command or subcommand. A handle, valid as long as its CommandLine. The values that options are
/// bound to keep their defaults unless the command line has the option, and must outlive parsing.
///
/// CLI11 does the work behind this interface. Its header costs seconds in each file that includes
/// it, so only command_line.cc does.
class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}

  Command AddCommand(const std::string& name, const std::string& help) const;
  void RequireCommand() const;  ///< One of the subcommands has to be given.
  /// True where given. A `name` "!--no-x" sets false.
  Option AddFlag(const std::string& name, bool& value, const std::string& help) const;
  /// `name` without dashes is a positional argument. `Value`: bool excepted, the types of the
  /// instantiations in command_line.cc.
  template <typename Value>
  Option AddOption(const std::string& name, Value& value, const std::string& help) const;
  /// `run` is called while the command line is parsed, if it names this command.
  void OnRun(std::function<void()> run) const;

 private:
  CLI::App* app_;
};

/// Parses `arguments` (without the program's name) with the commands that `add` adds, runs the one
/// that is named, and returns the exit code: 0, or that of CheckFailed. Prints help and version.
/// Throws InputError for a wrong command line, and what the command throws.
int RunCommandLine(const std::string& program, const std::string& about, const std::string& version,
                   std::vector<std::string> arguments, const std::function<void(Command)>& add);

}  // namespace hpdm
