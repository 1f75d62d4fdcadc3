#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// Options of `hpdm report --all`.
struct FleetOptions {
  std::filesystem::path folder = {};  ///< Folder with session folders, at any depth.
  std::filesystem::path table = {};   ///< As for OpenSessionTable; empty: no table.
  int jobs = 1;                       ///< Processes at once.
  double patience = 600;              ///< Longest time for one session, s.
  HandlingLimits limits = {};
  bool again = false;       ///< Also read unchanged sessions that the table has.
  bool print_lines = true;  ///< Print each finished session's line on stdout.
  std::vector<nlohmann::ordered_json>* lines = nullptr;  ///< Also takes each finished line.
  /// The program that reads one session with `report FOLDER --json-line`.
  std::string program = "/proc/self/exe";
};

struct FleetSummary {
  std::size_t sessions = 0;  ///< Sessions found.
  std::size_t reported = 0;
  std::size_t unchanged = 0;  ///< Sessions with a report in the table already.
  std::size_t failed = 0;     ///< Failed now, or before and unchanged; also unreadable folders.
};

/// Reads every session in a process of its own, so that a log that crashes or hangs its reader
/// costs only that session.
///   1. Sessions that the table has and that are unchanged are skipped, so that a run continues
///      where an earlier one ended.
///   2. Each finished session's line (session_line.h) is added to the table, and printed on stdout
///      if `print_lines`.
///   3. Each failure is named in one line on stderr.
/// Memory: one line per process and about 300 bytes per session. Throws InputError if the folder,
/// the table or stdout cannot be used, MachineError if no process can be started. Main thread.
FleetSummary ReportAll(const FleetOptions& options);

/// Adds lines of `--json-line` from files ("-": standard input) or pipes to a table, in any order.
/// For each session the line of the newest log stays (Replaces). A line that is not a session's is
/// named on stderr and counts as failed. Throws InputError if a file or the table cannot be used.
FleetSummary CollectLines(const std::vector<std::string>& files,
                          const std::filesystem::path& table);

}  // namespace hpdm
