#include "tools/report/fleet/session_search.h"

#include <algorithm>
#include <system_error>

#include "engine/base/error.h"
#include "tools/session/session_path.h"

namespace hpdm {

namespace fs = std::filesystem;

FoundSessions FindSessions(const fs::path& root) {
  std::error_code error;
  const fs::path whole_root = fs::canonical(root, error);
  if (error || !fs::is_directory(whole_root)) {
    throw InputError(root.string() + ": not a folder; give one that contains session folders");
  }
  FoundSessions found;
  std::vector<fs::path> to_read = {""};  // relative
  while (!to_read.empty()) {
    const fs::path folder = std::move(to_read.back());
    to_read.pop_back();
    // Each step is checked: a folder may vanish while it is read.
    fs::directory_iterator entry(whole_root / folder, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
      const fs::path name = entry->path().filename();
      std::error_code gone;
      const fs::file_status status = entry->symlink_status(gone);
      if (name == kSessionLogName) {
        if (fs::is_symlink(status) && LeadsOutside(whole_root / folder, name)) {
          found.outside.push_back((folder / name).string());
        } else {
          found.folders.push_back(folder);
        }
      }
      if (fs::is_directory(status)) to_read.push_back(folder / name);
    }
    if (error) found.unread.push_back(folder.string() + ": " + error.message());
    error.clear();
  }
  std::sort(found.folders.begin(), found.folders.end());
  return found;
}

}  // namespace hpdm
