#include "tools/report/session_line.h"

#include <sys/stat.h>

#include <exception>

#include "engine/error.h"
#include "tools/report/path_text.h"
#include "tools/report/report_json.h"
#include "tools/report/session_files.h"
#include "tools/report/session_search.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

Json Begin(const std::string& session, std::optional<int> exit_code,
           const std::optional<LogStamp>& stamp) {
  return {{"session", session},
          {"exit_code", exit_code ? Json(*exit_code) : Json()},
          {"log_bytes", stamp ? Json(stamp->bytes) : Json()},
          {"log_mtime_ns", stamp ? Json(stamp->mtime_ns) : Json()}};
}

}  // namespace

std::string SessionName(const std::filesystem::path& folder) {
  std::filesystem::path name = folder.lexically_normal();
  if (!name.has_filename()) name = name.parent_path();  // a slash at the end
  return name.empty() ? "." : PathText(name.native());
}

std::optional<LogStamp> StampOf(const std::filesystem::path& session) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(session, error);
  struct stat facts {};
  if (stat((is_folder ? session / kSessionLogName : session).c_str(), &facts) != 0) {
    return std::nullopt;
  }
  return LogStamp{facts.st_size,
                  facts.st_mtim.tv_sec * kNanosecondsPerSecond + facts.st_mtim.tv_nsec};
}

Json SessionLine(const std::filesystem::path& path, double force_limit) {
  const std::string session = SessionName(path);
  const std::optional<LogStamp> stamp = StampOf(path);  // before it is read: it may still grow
  try {
    Json report = ToJson(ReadSession(FindSessionFiles(path), force_limit).report);
    report.erase("log");
    Json line = Begin(session, 0, stamp);
    line["report"] = std::move(report);
    return line;
  } catch (const InputError& error) {
    return FailedLine(session, 2, stamp, error.what());
  } catch (const std::exception& error) {
    return FailedLine(session, 3, stamp, error.what());
  }
}

Json FailedLine(const std::string& session, std::optional<int> exit_code,
                const std::optional<LogStamp>& stamp, const std::string& error) {
  Json line = Begin(session, exit_code, stamp);
  line["error"] = PathText(error);
  return line;
}

std::string LineText(const Json& line) {
  return line.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace hpdm
