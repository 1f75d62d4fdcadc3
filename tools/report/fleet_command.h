#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace hpdm {

/// The options of `hpdm report` for many sessions.
struct FleetArguments {
  bool all = false;
  bool json_line = false;
  std::vector<std::string> collect;
  int jobs = 0;
  double patience = 600;
  bool again = false;
};

/// Adds them to the command `hpdm report`; `single` are its options for one session alone.
void AddFleetOptions(CLI::App* report, const std::vector<CLI::Option*>& single,
                     FleetArguments* arguments);

/// Does what they ask for; false: they ask for nothing. `session` is what the command was given, a
/// session's folder or with --all one of many, `out` its --out. A failed session is
/// CLI::RuntimeError with the exit code.
bool RunFleetCommand(const FleetArguments& arguments, const std::string& session,
                     const std::string& out, double force_limit);

}  // namespace hpdm
