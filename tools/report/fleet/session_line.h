#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace hpdm {

/// Of the figures in a line: to be raised with every change of what they mean or how they are
/// computed, so that a table does not mix them.
inline constexpr int kReportVersion = 1;

/// What tells one state of a session from another without reading it.
struct SessionStamp {
  std::int64_t log_bytes = 0;
  std::int64_t log_mtime_ns = 0;      ///< Time of its last change, ns since 1970.
  std::int64_t summary_mtime_ns = 0;  ///< Of summary.json, which has the scene's name; 0 without.
  bool operator==(const SessionStamp&) const = default;
};

/// Of a session's folder or of a bare log; none where there is no log.
std::optional<SessionStamp> StampOf(const std::filesystem::path& session);

/// What a session is called in lines and tables: its folder's path, without "./" before and a slash
/// behind, as PathText.
std::string SessionName(const std::filesystem::path& folder);

/// One session, a folder or a bare log, as one JSON object, whatever becomes of it: the unit that
/// `hpdm report` prints for a cluster's job and collects into tables.
///
///     session        its SessionName, as it was given or relative to the folder of all
///     exit_code      0 reported; 2 no usable log, 3 the machine lacks something;
///                    null: it crashed or took too long
///     report_version   kReportVersion
///     log_bytes, log_mtime_ns, summary_mtime_ns   when it was read (SessionStamp); null where the
///                    log could not be opened, which may be otherwise the next time
///     report         as report_json.h, without its `log`; with exit_code 0
///     error          one line; otherwise
nlohmann::ordered_json SessionLine(const std::filesystem::path& path, double force_limit);

/// The same of a session that could not tell it itself.
nlohmann::ordered_json FailedLine(const std::string& session, std::optional<int> exit_code,
                                  const std::optional<SessionStamp>& stamp,
                                  const std::string& error);

/// As one line of text, without its end.
std::string LineText(const nlohmann::ordered_json& line);

}  // namespace hpdm
