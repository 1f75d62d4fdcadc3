#pragma once

#include <filesystem>
#include <string>

namespace hpdm {

/// Name of the log in a session's folder.
inline constexpr char kSessionLogName[] = "session.lcmlog";

/// A file that is really in the folder; empty where it is missing, no regular file, or a link out
/// of the folder. A session folder may come from anyone: what it links to elsewhere is not read.
std::filesystem::path FileInside(const std::filesystem::path& folder,
                                 const std::filesystem::path& name);

/// Whether the name, a link, leads to something outside of the folder.
bool LeadsOutside(const std::filesystem::path& folder, const std::filesystem::path& name);

/// The log of what a command was given: of a session's folder its session.lcmlog, anything else is
/// the log itself. Throws InputError where the folder holds none.
std::string LogPathOf(const std::filesystem::path& session);

}  // namespace hpdm
