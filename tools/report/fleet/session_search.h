#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hpdm {

/// Session folders at any depth.
struct FoundSessions {
  std::vector<std::filesystem::path> folders;  ///< Relative to the folder searched, sorted.
  std::vector<std::string> unread;             ///< Folders that could not be read, and why.
  std::vector<std::string> outside;  ///< Logs that are links out of their folder: skipped.
};

/// Folders with something named session.lcmlog in `root` and below it. Links to folders are not
/// followed, and a log that is a link out of its session folder is none of it (session_path.h):
/// what they lead to inside `root` is found there.
/// Throws InputError where `root` is no folder.
FoundSessions FindSessions(const std::filesystem::path& root);

}  // namespace hpdm
