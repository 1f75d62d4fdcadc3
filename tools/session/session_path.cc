#include "tools/session/session_path.h"

#include <system_error>

#include "engine/base/error.h"
#include "scenes/loader/scene_files.h"

namespace hpdm {

namespace fs = std::filesystem;

fs::path FileInside(const fs::path& folder, const fs::path& name) {
  const fs::path file = folder / name;
  std::error_code error;
  if (!LiesInside(folder, file) || !fs::is_regular_file(file, error)) return {};
  return fs::canonical(file, error);
}

bool LeadsOutside(const fs::path& folder, const fs::path& name) {
  const fs::path target = folder / name;
  std::error_code error;
  return fs::exists(target, error) && !LiesInside(folder, target);
}

std::string LogPathOf(const fs::path& session) {
  std::error_code error;
  if (!fs::is_directory(session, error)) return session.string();
  const fs::path log = session / kSessionLogName;
  if (LeadsOutside(session, kSessionLogName)) {
    throw InputError(log.string() +
                     ": is a link out of the session's folder; give the log that it points to");
  }
  if (FileInside(session, kSessionLogName).empty()) {
    throw InputError(session.string() + ": contains no " + kSessionLogName +
                     "; give a folder that hpdm run wrote");
  }
  return log.string();
}

}  // namespace hpdm
