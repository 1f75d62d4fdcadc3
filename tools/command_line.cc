#include "tools/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <optional>
#include <set>
#include <utility>

#include "engine/base/error.h"
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
  std::reverse(arguments.begin(), arguments.end());  // CLI11 takes the last one first
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CheckFailed& failed) {
    return failed.exit_code;
  } catch (const CLI::ParseError& error) {
    throw InputError(std::string(error.what()) + "; see " + program + " --help");
  }
  return 0;
}

}  // namespace hpdm
