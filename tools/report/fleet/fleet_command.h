#pragma once

#include <string>
#include <vector>

#include "tools/command_line.h"

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
void AddFleetOptions(Command report, const std::vector<Option>& single, FleetArguments* arguments);

/// Does what they ask for; false: they ask for nothing. `session` is what the command was given, a
/// session's folder or with --all one of many, `out` its --out. A failed session is
/// CheckFailed with the exit code.
bool RunFleetCommand(const FleetArguments& arguments, const std::string& session,
                     const std::string& out, double force_limit);

}  // namespace hpdm
