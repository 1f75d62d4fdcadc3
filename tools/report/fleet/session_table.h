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

/// What a table holds of a session, as far as it decides whether to read its log again.
struct KnownSession {
  std::optional<int> exit_code;  ///< None: it crashed or took too long.
  int version = 0;               ///< kReportVersion of who read it; 0: not told.
  std::optional<SessionStamp> stamp;
  std::optional<double> force_limit;  ///< N; none without a report.
  std::string error;
};

/// Where the lines of many sessions are kept. Of a session the last line counts. Whatever
/// interrupts a program that adds, what it added before is there; several may add at once. One
/// thread.
class SessionTable {
 public:
  virtual ~SessionTable() = default;

  /// By session.
  virtual std::unordered_map<std::string, KnownSession> Known() = 0;
  /// Keeps lines of sessions (session_line.h), all or none. Throws InputError where they cannot be
  /// written.
  virtual void Add(std::span<const nlohmann::ordered_json> lines) = 0;
};

/// An SQLite file (sqlite_table.h), or with the name's end .jsonl the lines themselves. Made when
/// missing. Throws InputError where it cannot be used or is something else.
std::unique_ptr<SessionTable> OpenSessionTable(const std::filesystem::path& path);

/// What decides about reading again, of one line. None: it is not the line of a session.
std::optional<KnownSession> KnownFrom(const nlohmann::ordered_json& line);

/// Of two lines of a session in no known order, whether `line` is the one to keep: that of the
/// newer log, then one with a report, then of the newer version; of equals it is.
bool Replaces(const KnownSession& line, const KnownSession& kept);

}  // namespace hpdm
