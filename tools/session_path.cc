#include "tools/session_path.h"

#include <algorithm>
#include <system_error>

#include "engine/error.h"

namespace hpdm {

namespace fs = std::filesystem;

namespace {

struct Target {
  fs::path path;  // empty: nothing is there
  bool inside = false;
};

Target TargetOf(const fs::path& folder, const fs::path& name) {
  std::error_code error;
  const fs::path base = fs::canonical(folder.empty() ? "." : folder, error);
  if (error) return {};
  const fs::path target = fs::canonical(base / name, error);
  if (error) return {};
  const auto ends = std::mismatch(base.begin(), base.end(), target.begin(), target.end());
  return {target, ends.first == base.end()};
}

}  // namespace

fs::path FileInside(const fs::path& folder, const fs::path& name) {
  const Target target = TargetOf(folder, name);
  std::error_code error;
  return target.inside && fs::is_regular_file(target.path, error) ? target.path : fs::path();
}

bool LeadsOutside(const fs::path& folder, const fs::path& name) {
  const Target target = TargetOf(folder, name);
  return !target.path.empty() && !target.inside;
}

std::string LogPathOf(const fs::path& session) {
  std::error_code error;
  if (!fs::is_directory(session, error)) return session.string();
  const fs::path log = session / kSessionLogName;
  if (LeadsOutside(session, kSessionLogName)) {
    throw InputError(log.string() +
                     ": is a link out of the session's folder; give the log that it leads to");
  }
  if (FileInside(session, kSessionLogName).empty()) {
    throw InputError(session.string() + ": holds no " + kSessionLogName +
                     "; give the folder that hpdm run --out made");
  }
  return log.string();
}

}  // namespace hpdm
