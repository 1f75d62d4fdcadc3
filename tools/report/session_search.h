#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hpdm {

/// Name of the log in a session's folder.
inline constexpr char kSessionLogName[] = "session.lcmlog";

/// Session folders at any depth.
struct FoundSessions {
  std::vector<std::filesystem::path> folders;  ///< Relative to the folder searched, sorted.
  std::vector<std::string> unread;             ///< Folders that could not be read, and why.
  std::vector<std::string> outside;            ///< Logs that are links out of the folder: skipped.
};

/// Folders with something named session.lcmlog in `root` and below it. Links to folders are not
/// followed: what they lead to inside `root` is found there, and what is outside is none of it.
/// Throws InputError where `root` is no folder.
FoundSessions FindSessions(const std::filesystem::path& root);

}  // namespace hpdm
