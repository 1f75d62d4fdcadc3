#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// A picture of a session folder, ready for a page.
struct SessionPicture {
  std::string name;      ///< Path in the folder: "deepest.png", "frames/frame_000012.png".
  std::string caption;   ///< For people.
  std::string data_uri;  ///< "data:image/png;base64,..."
};

/// Files of a session folder. Files outside the folder are never read: links out of it count as
/// missing.
struct SessionFiles {
  std::filesystem::path folder;  ///< Empty for a bare log.
  std::filesystem::path log;
  std::string scene;                     ///< Name from summary.json; empty if unknown.
  std::vector<SessionPicture> pictures;  ///< deepest.png, last.png and some of frames/.
  std::vector<std::string> missing;      ///< Names of missing files.
};

/// Finds the files of `path`, a session's folder or a bare .lcmlog. Throws InputError if there is
/// neither.
SessionFiles FindSessionFiles(const std::filesystem::path& path);

/// Reads the log; the report has the scene's name. Throws InputError as the other ReadSession.
SessionReading ReadSession(const SessionFiles& files, double force_limit);

/// Loads pictures of up to 1.5 MB in all, the most important first. A separate function, because a
/// table of many sessions does not need them.
void LoadPictures(SessionFiles* files);

}  // namespace hpdm
