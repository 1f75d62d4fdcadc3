#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// What `hpdm report --all` does.
struct FleetOptions {
  std::filesystem::path folder = {};        ///< Session folders in it, at any depth.
  std::filesystem::path table = {};         ///< As OpenSessionTable; empty: none.
  int jobs = 1;                             ///< Processes at once.
  double patience = 600;                    ///< s, for one session.
  double force_limit = kDefaultForceLimit;  ///< N.
  bool again = false;  ///< Also those that the table has and that are unchanged.
  /// The program whose `report FOLDER --json-line` reads one session.
  std::string program = "/proc/self/exe";
};

struct FleetSummary {
  std::size_t sessions = 0;  ///< Found.
  std::size_t reported = 0;
  std::size_t unchanged = 0;  ///< In the table already, with a report.
  std::size_t failed = 0;     ///< Now, or before and unchanged; folders that could not be read too.
};

/// Reads every session in a process of its own, so that a log that crashes or hangs the reader
/// costs that session alone. Prints each one's line (session_line.h) on stdout as it is done, adds
/// it to the table, and names each failure in one line on stderr. Of a table it goes on where an
/// earlier run ended. Memory: one line for each process, and some 300 bytes a session. Throws
/// InputError where the folder, the table or stdout cannot be used, MachineError where no process
/// can be started. Main thread.
FleetSummary ReportAll(const FleetOptions& options);

/// Adds the lines that `--json-line` printed, from files ("-": standard input) or pipes, to a
/// table, in whatever order they come: of a session that of the newest log stays (Replaces). Names
/// each line that is none of a session on stderr and counts it as failed. Throws InputError where a
/// file or the table cannot be used.
FleetSummary CollectLines(const std::vector<std::string>& files,
                          const std::filesystem::path& table);

}  // namespace hpdm
