#pragma once

#include <filesystem>
#include <string>

namespace hpdm {

/// Name of the log in a session's folder.
inline constexpr char kSessionLogName[] = "session.lcmlog";

/// Returns the path of a file inside the folder. Returns an empty path if the file is missing, not
/// a regular file, or a link out of the folder: a session folder may come from anyone, so files
/// that it links to elsewhere are not read.
std::filesystem::path FileInside(const std::filesystem::path& folder,
                                 const std::filesystem::path& name);

/// True if the name is a link that leads out of the folder.
bool LeadsOutside(const std::filesystem::path& folder, const std::filesystem::path& name);

/// Returns the log of a command's argument: the session.lcmlog of a session's folder, or the
/// argument itself if it is not a folder. Throws InputError if the folder has no log.
std::string LogPathOf(const std::filesystem::path& session);

}  // namespace hpdm
