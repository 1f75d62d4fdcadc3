#include "tools/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <optional>
#include <set>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/nearest_word.h"
#include "engine/base/quoted_token.h"
#include "tools/shared/number_text.h"

namespace hpdm {
namespace {

// CLI11's own Range accepts NaN.
CLI::Validator NumberFrom(double min, double max) {
  const auto text = [](double number) {
    char digits[32];
    constexpr auto kFixed = std::chars_format::fixed;
    return std::string(digits, std::to_chars(digits, digits + sizeof digits, number, kFixed).ptr);
  };
  const std::string range = text(min) + " to " + text(max);
  return {[=](std::string& given) {
            double number = 0;
            if (!ReadNumber(given, &number)) return given + " is not a number; give " + range;
            const bool fits = number >= min && number <= max;
            return fits ? std::string() : given + " is out of range; give " + range;
          },
          "in " + range};
}

/// The command that the words name, its subcommands and their subcommands, outermost first.
std::vector<const CLI::App*> NamedCommands(const CLI::App& app) {
  std::vector<const CLI::App*> named = {&app};
  while (!named.back()->get_subcommands().empty()) {
    named.push_back(named.back()->get_subcommands().front());
  }
  return named;
}

/// Returns the fault of a word that is none of `known`, with the one that it may misspell.
std::string Unknown(const std::string& kind, const std::string& word,
                    const std::vector<std::string>& known) {
  const std::vector<std::string_view> words(known.begin(), known.end());
  const std::string nearest(NearestWord(word, words));
  const std::string fault = "unknown " + kind + " " + Quoted(word);
  return nearest.empty() ? fault : fault + "; did you mean " + nearest + "?";
}

std::string UnknownOption(const std::string& word, const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return Unknown("option", word.substr(0, word.find('=')), names);
}

std::string UnknownCommand(const std::string& word, const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* known : command.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(known->get_name());
  }
  return Unknown("command", word, names);
}

/// Returns the fault of the first word that no command takes, or "". Where a command is missing, the
/// words behind a misspelled one were meant for it; elsewhere an option comes before other words.
std::string UnknownWord(const std::vector<const CLI::App*>& commands) {
  std::string other;
  for (const CLI::App* command : commands) {
    const bool needs_command = command->get_require_subcommand_min() > 0;
    for (const std::string& word : command->remaining()) {
      if (word == "--") continue;
      if (word.starts_with('-')) return UnknownOption(word, *command);
      if (needs_command) return UnknownCommand(word, *command);
      if (other.empty()) other = "unexpected argument " + Quoted(word);
    }
  }
  return other;
}

/// Says in plain words what CLI11 says of an option with too many or too few values.
std::string WrongCount(const std::string& fault) {
  const std::string name = fault.substr(0, fault.find(": "));
  if (fault.ends_with(" missing")) return name + ": has no value; give one";
  if (fault.find(": At Most 1 ") != std::string::npos) {
    return name + ": is given more than once; give it once";
  }
  return fault;
}

/// Returns one line for a command line that CLI11 refuses, with the help of the command in it.
std::string Fault(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<const CLI::App*> commands = NamedCommands(app);
  std::string help;
  for (const CLI::App* command : commands) help += command->get_name() + " ";
  help = "; see " + help + "--help";
  // CLI11 reports a missing word first, which a misspelled one may have been meant to be.
  const bool incomplete = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
  if (incomplete || dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    const std::string unknown = UnknownWord(commands);
    if (unknown.ends_with('?')) return unknown;
    if (!unknown.empty()) return unknown + help;
  }
  const CLI::App& last = *commands.back();
  if (incomplete && last.get_require_subcommand_min() > 0) return "a command is missing" + help;
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    return WrongCount(error.what()) + help;
  }
  return error.what() + help;
}

/// Makes "COMMAND --help" out of "help COMMAND", and "--help" out of "help". Returns true if it did.
bool TranslateHelp(std::vector<std::string>* arguments) {
  if (arguments->empty() || arguments->front() != "help") return false;
  arguments->erase(arguments->begin());
  arguments->emplace_back("--help");
  return true;
}

}  // namespace

Option Option::Required() {
  option_->required();
  return *this;
}

Option Option::ShowDefault() {
  option_->capture_default_str();
  return *this;
}

Option Option::From(double min, double max) {
  option_->check(NumberFrom(min, max));
  return *this;
}

Option Option::OneOf(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return *this;
}

Option Option::OneOfUnlisted(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words).description(""));
  return *this;
}

Option Option::SplitAt(char separator) {
  option_->delimiter(separator);
  return *this;
}

Option Option::OneValueEach() {
  option_->allow_extra_args(false);
  return *this;
}

Option Option::OptionalValue(const std::string& value_name) {
  option_->expected(0, 1)->type_name(value_name);
  return *this;
}

Option Option::Needs(const Option& other) {
  option_->needs(other.option_);
  return *this;
}

Option Option::Excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

Option Option::Excludes(const std::string& other) {
  option_->excludes(other);
  return *this;
}

bool Option::Given() const { return option_->count() > 0; }

Command Command::AddCommand(const std::string& name, const std::string& help) const {
  return Command(app_->add_subcommand(name, help));
}

void Command::RequireCommand() const { app_->require_subcommand(1); }

Option Command::AddFlag(const std::string& name, bool& value, const std::string& help) const {
  return Option(app_->add_flag(name, value, help));
}

template <typename Value>
Option Command::AddOption(const std::string& name, Value& value, const std::string& help) const {
  return Option(app_->add_option(name, value, help));
}

template Option Command::AddOption(const std::string&, int&, const std::string&) const;
template Option Command::AddOption(const std::string&, double&, const std::string&) const;
template Option Command::AddOption(const std::string&, std::optional<double>&,
                                   const std::string&) const;
template Option Command::AddOption(const std::string&, std::string&, const std::string&) const;
template Option Command::AddOption(const std::string&, std::vector<std::string>&,
                                   const std::string&) const;
template Option Command::AddOption(const std::string&, std::set<std::string>&,
                                   const std::string&) const;

void Command::OnRun(std::function<void()> run) const { app_->callback(std::move(run)); }

int RunCommandLine(const std::string& program, const std::string& about, const std::string& version,
                   std::vector<std::string> arguments, const std::function<void(Command)>& add) {
  CLI::App app(about, program);
  app.require_subcommand(1);
  app.set_version_flag("--version", version);
  add(Command(&app));
  const bool help = TranslateHelp(&arguments);
  std::reverse(arguments.begin(), arguments.end());  // CLI11 takes the last one first
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::Success& asked) {  // --help, --version
    // Words that should have named a command are a mistake, also before --help.
    const std::vector<const CLI::App*> commands = NamedCommands(app);
    const bool lacks_command = commands.back()->get_require_subcommand_min() > 0;
    const std::string unknown = help || lacks_command ? UnknownWord(commands) : std::string();
    if (!unknown.empty()) {
      throw InputError(unknown + (unknown.ends_with('?') ? "" : "; see " + program + " --help"));
    }
    return app.exit(asked);
  } catch (const CheckFailed& failed) {
    return failed.exit_code;
  } catch (const CLI::ParseError& error) {
    throw InputError(Fault(app, error));
  }
  return 0;
}

}  // namespace hpdm
