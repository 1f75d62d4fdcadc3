#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hpdm {

/// Result of a search for session folders.
struct FoundSessions {
  std::vector<std::filesystem::path> folders;  ///< Relative to the folder searched, sorted.
  std::vector<std::string> unread;             ///< Folders that could not be read, and why.
  std::vector<std::string> outside;            ///< Skipped logs: links out of their folder.
};

/// Finds folders that contain session.lcmlog, in `root` and below it. Links to folders are not
/// followed, and logs that are links out of their session folder are skipped (session_path.h).
/// Throws InputError if `root` is not a folder.
FoundSessions FindSessions(const std::filesystem::path& root);

}  // namespace hpdm
