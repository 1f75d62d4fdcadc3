#pragma once

#include <string>
#include <vector>

#include "engine/base/handling_limits.h"
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
  std::string curve;
};

/// Adds the options to the command `hpdm report`; `single` are its options for a single session.
void AddFleetOptions(Command report, const std::vector<Option>& single, FleetArguments* arguments);

/// Runs the command for many sessions if the arguments ask for it; returns false if not. `session`:
/// a session's folder, or with --all a folder of many; `out`: the argument of --out. Throws
/// CheckFailed with the exit code if a session failed.
bool RunFleetCommand(const FleetArguments& arguments, const std::string& session,
                     const std::string& out, const HandlingLimits& limits);

}  // namespace hpdm
