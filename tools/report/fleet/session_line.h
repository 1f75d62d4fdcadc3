#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "engine/base/handling_limits.h"

namespace hpdm {

/// Version of the figures in a line. Raise it with every change of their meaning or computation, so
/// that a table does not mix them.
inline constexpr int kReportVersion = 6;

/// Identifies the state of a session's files without reading them.
struct SessionStamp {
  std::int64_t log_bytes = 0;
  std::int64_t log_mtime_ns = 0;      ///< Time of the log's last change, ns since 1970.
  std::int64_t summary_mtime_ns = 0;  ///< The same of summary.json (scene's name); 0 if missing.
  bool operator==(const SessionStamp&) const = default;
};

/// Returns the stamp of a session's folder or of a bare log; nothing without a log.
std::optional<SessionStamp> StampOf(const std::filesystem::path& session);

/// Returns a session's name in lines and tables: its folder's path as PathText, without a leading
/// "./" and a final slash.
std::string SessionName(const std::filesystem::path& folder);

/// Reads one session, a folder or a bare log, and returns its report, or its failure, as one JSON
/// object. `hpdm report --json-line` prints it, and --collect puts it into tables.
///
///     session        its SessionName, as given or relative to the folder of --all
///     exit_code      0 reported; 2 no usable log, 3 the machine lacks something;
///                    null: it crashed or took too long
///     report_version   kReportVersion
///     log_bytes, log_mtime_ns, summary_mtime_ns   its SessionStamp; null if the log could not be
///                    opened, which may succeed next time
///     report         as in report_json.h, without `log`; with exit_code 0 only
///     error          one line; with any other exit_code
nlohmann::ordered_json SessionLine(const std::filesystem::path& path,
                                   const HandlingLimits& limits = {});

/// Returns the line of a session that failed.
nlohmann::ordered_json FailedLine(const std::string& session, std::optional<int> exit_code,
                                  const std::optional<SessionStamp>& stamp,
                                  const std::string& error);

/// Returns a line as text, without the line's end.
std::string LineText(const nlohmann::ordered_json& line);

}  // namespace hpdm
