#pragma once

#include <string>
#include <vector>

#include "tools/command_line.h"

namespace hpdm {

/// Each function adds one subcommand, which runs while the command line is parsed. Subcommands
/// throw InputError for bad input, MachineError where the machine lacks something, and CheckFailed
/// for a failed check. `command_line`: the program and its arguments, for the session's record.
void AddRunCommand(Command app, std::vector<std::string> command_line);
void AddCheckCommand(Command app);
void AddInspectCommand(Command app);
void AddGenerateCommand(Command app);
void AddLogCommand(Command app);
void AddSpyCommand(Command app);
void AddTeachCommand(Command app);
void AddReplayCommand(Command app);
void AddReportCommand(Command app);
void AddSolveCommand(Command app);
void AddChartCommand(Command app);
void AddPlanCommand(Command app);
void AddBenchCommand(Command app);
void AddHapticsCommand(Command app);
void AddStressCommand(Command app);

}  // namespace hpdm
