#include "tools/report/fleet/session_table.h"

#include <limits>
#include <tuple>

#include "tools/report/fleet/lines_table.h"
#include "tools/report/fleet/sqlite_table.h"

namespace hpdm {

using Json = nlohmann::ordered_json;

std::unique_ptr<SessionTable> OpenSessionTable(const std::filesystem::path& path) {
  if (path.extension() == ".jsonl") return std::make_unique<LinesTable>(path);
  return std::make_unique<SqliteTable>(path);
}

std::optional<KnownSession> KnownFrom(const Json& line) {
  if (!line.is_object() || !line.contains("session") || !line["session"].is_string() ||
      !line.contains("exit_code")) {
    return std::nullopt;
  }
  const auto integer = [&line](const char* key) -> std::optional<std::int64_t> {
    if (!line.contains(key) || !line[key].is_number_integer()) return std::nullopt;
    return line[key].get<std::int64_t>();
  };
  KnownSession session;
  if (const auto code = integer("exit_code")) session.exit_code = static_cast<int>(*code);
  session.version = static_cast<int>(integer("report_version").value_or(0));
  const auto bytes = integer("log_bytes");
  const auto mtime_ns = integer("log_mtime_ns");
  if (bytes && mtime_ns) {
    session.stamp = SessionStamp{*bytes, *mtime_ns, integer("summary_mtime_ns").value_or(0)};
  }
  const Json::json_pointer force("/report/force_limit_N"), depth("/report/depth_limit_m");
  const auto number = [&line](const Json::json_pointer& key) {
    return line.contains(key) && line[key].is_number();
  };
  if (number(force) && number(depth)) session.limits = {.force = line[force], .depth = line[depth]};
  if (line.contains("error") && line["error"].is_string()) session.error = line["error"];
  const bool has_report = line.contains("report") && line["report"].is_object();
  if (session.exit_code == 0 ? !has_report : session.error.empty()) return std::nullopt;
  return session;
}

bool Replaces(const KnownSession& line, const KnownSession& kept) {
  const auto rank = [](const KnownSession& session) {
    const std::int64_t mtime_ns =
        session.stamp ? session.stamp->log_mtime_ns : std::numeric_limits<std::int64_t>::min();
    return std::tuple(mtime_ns, session.exit_code == 0, session.version);
  };
  return rank(line) >= rank(kept);
}

}  // namespace hpdm
