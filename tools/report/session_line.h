#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace hpdm {

/// What tells one state of a log from another without reading it.
struct LogStamp {
  std::int64_t bytes = 0;
  std::int64_t mtime_ns = 0;  ///< Time of its last change, ns since 1970.
  bool operator==(const LogStamp&) const = default;
};

/// Of a session folder's log, or of a bare log; none where there is no such file.
std::optional<LogStamp> StampOf(const std::filesystem::path& session);

/// What a session is called in lines and tables: its folder's path, without "./" before and a slash
/// behind, as PathText.
std::string SessionName(const std::filesystem::path& folder);

/// One session, a folder or a bare log, as one JSON object, whatever becomes of it: the unit that
/// `hpdm report` prints for a cluster's job and collects into tables.
///
///     session        its SessionName, as it was given or relative to the folder of all
///     exit_code      0 reported; 2 no usable log, 3 the machine lacks something;
///                    null: it crashed or took too long
///     log_bytes, log_mtime_ns   of the log when it was read (LogStamp); null without one
///     report         as report_json.h, without its `log`; with exit_code 0
///     error          one line; otherwise
nlohmann::ordered_json SessionLine(const std::filesystem::path& path, double force_limit);

/// The same of a session that could not tell it itself.
nlohmann::ordered_json FailedLine(const std::string& session, std::optional<int> exit_code,
                                  const std::optional<LogStamp>& stamp, const std::string& error);

/// As one line of text, without its end.
std::string LineText(const nlohmann::ordered_json& line);

}  // namespace hpdm
