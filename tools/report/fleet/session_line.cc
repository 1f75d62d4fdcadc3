#include "tools/report/fleet/session_line.h"

#include <sys/stat.h>

#include <exception>

#include "engine/base/error.h"
#include "lcmtypes/log/log.h"
#include "tools/report/metrics/report_json.h"
#include "tools/report/metrics/session_files.h"
#include "tools/session/session_path.h"
#include "tools/shared/path_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

Json Begin(const std::string& session, std::optional<int> exit_code,
           const std::optional<SessionStamp>& stamp) {
  return {{"session", session},
          {"exit_code", exit_code ? Json(*exit_code) : Json()},
          {"report_version", kReportVersion},
          {"log_bytes", stamp ? Json(stamp->log_bytes) : Json()},
          {"log_mtime_ns", stamp ? Json(stamp->log_mtime_ns) : Json()},
          {"summary_mtime_ns", stamp ? Json(stamp->summary_mtime_ns) : Json()}};
}

std::int64_t MtimeOf(const struct stat& facts) {
  return facts.st_mtim.tv_sec * kNanosecondsPerSecond + facts.st_mtim.tv_nsec;
}

}  // namespace

std::string SessionName(const std::filesystem::path& folder) {
  std::filesystem::path name = folder.lexically_normal();
  if (!name.has_filename()) name = name.parent_path();  // removes a final slash
  return name.empty() ? "." : PathText(name.native());
}

std::optional<SessionStamp> StampOf(const std::filesystem::path& session) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(session, error);
  struct stat facts {};
  if (stat((is_folder ? session / kSessionLogName : session).c_str(), &facts) != 0) {
    return std::nullopt;
  }
  SessionStamp stamp{.log_bytes = facts.st_size, .log_mtime_ns = MtimeOf(facts)};
  if (is_folder && stat((session / "summary.json").c_str(), &facts) == 0) {
    stamp.summary_mtime_ns = MtimeOf(facts);
  }
  return stamp;
}

Json SessionLine(const std::filesystem::path& path, const HandlingLimits& limits) {
  const std::string session = SessionName(path);
  const std::optional<SessionStamp> stamp = StampOf(path);  // before reading: the log may grow
  bool opened = false;
  try {
    const SessionFiles files = FindSessionFiles(path);
    const LogReader log(files.log.string());
    opened = true;
    Json report = ToJson(ReadSession(files, limits.force, limits.depth).report);
    report.erase("log");
    Json line = Begin(session, 0, stamp);
    line["report"] = std::move(report);
    return line;
  } catch (const InputError& error) {
    return FailedLine(session, 2, opened ? stamp : std::nullopt, error.what());
  } catch (const std::exception& error) {
    return FailedLine(session, 3, stamp, error.what());
  }
}

Json FailedLine(const std::string& session, std::optional<int> exit_code,
                const std::optional<SessionStamp>& stamp, const std::string& error) {
  Json line = Begin(session, exit_code, stamp);
  line["error"] = PathText(error);
  return line;
}

std::string LineText(const Json& line) {
  return line.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace hpdm
