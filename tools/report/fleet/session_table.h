#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>

#include "tools/report/fleet/session_line.h"

namespace hpdm {

/// The entries of a session in a table that decide whether to read its log again.
struct KnownSession {
  std::optional<int> exit_code;  ///< Nothing if its reader crashed or took too long.
  int version = 0;               ///< kReportVersion of its reader; 0: unknown.
  std::optional<SessionStamp> stamp;
  std::optional<HandlingLimits> limits;  ///< Nothing without a report.
  std::string error;
};

/// Stores the lines of many sessions; the last line of a session counts. Added lines stay even if
/// the program is interrupted later. Several programs may add at once. One thread.
class SessionTable {
 public:
  virtual ~SessionTable() = default;

  /// Returns the sessions of the table by name.
  virtual std::unordered_map<std::string, KnownSession> Known() = 0;
  /// Adds lines of sessions (session_line.h), all or none. Throws InputError if they cannot be
  /// written.
  virtual void Add(std::span<const nlohmann::ordered_json> lines) = 0;
};

/// Opens a table, and creates it if missing: a file of lines if the name ends with .jsonl, else an
/// SQLite file (sqlite_table.h). Throws InputError if it cannot be used or is something else.
std::unique_ptr<SessionTable> OpenSessionTable(const std::filesystem::path& path);

/// Returns the entries of a line; nothing if it is not the line of a session.
std::optional<KnownSession> KnownFrom(const nlohmann::ordered_json& line);

/// True if `line` should replace `kept`, a line of the same session: it is of a newer log, else has
/// a report, else is of a newer version, or is equal in all three.
bool Replaces(const KnownSession& line, const KnownSession& kept);

}  // namespace hpdm
