#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace hpdm {

/// Each adds one subcommand whose work runs while the command line is parsed. Bad input throws
/// InputError, a machine that lacks something MachineError, a failed check CLI::RuntimeError(1).
/// `command_line`: the program and its arguments, for the session's record.
void AddRunCommand(CLI::App& app, std::vector<std::string> command_line);
void AddCheckCommand(CLI::App& app);
void AddInspectCommand(CLI::App& app);
void AddGenerateCommand(CLI::App& app);
void AddLogCommand(CLI::App& app);
void AddSpyCommand(CLI::App& app);
void AddReplayCommand(CLI::App& app);
void AddReportCommand(CLI::App& app);
void AddSolveCommand(CLI::App& app);
void AddChartCommand(CLI::App& app);
void AddPlanCommand(CLI::App& app);
void AddBenchCommand(CLI::App& app);
void AddHapticsCommand(CLI::App& app);
void AddStressCommand(CLI::App& app);

}  // namespace hpdm
