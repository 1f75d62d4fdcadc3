#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// A picture of a session folder, ready for a page.
struct SessionPicture {
  std::string name;      ///< Below the folder: "deepest.png", "frames/frame_000012.png".
  std::string caption;   ///< For people.
  std::string data_uri;  ///< "data:image/png;base64,..."
};

/// What a session folder holds beside its log. Nothing outside of the folder is ever read: links
/// out of it count as missing.
struct SessionFiles {
  std::filesystem::path folder;  ///< Empty: a bare log.
  std::filesystem::path log;
  std::string scene;                     ///< Name, as summary.json has it; empty: not known.
  std::vector<SessionPicture> pictures;  ///< deepest.png, last.png and a few of frames/.
  std::vector<std::string> missing;      ///< What a session folder has and this one lacks.
};

/// `path`: a session's folder or a bare .lcmlog. Throws InputError where neither is there. Pictures
/// up to 1.5 MB in all are taken, those without which a report is poorer first.
SessionFiles FindSessionFiles(const std::filesystem::path& path);

/// Reads its log; the report has the scene's name. Throws InputError as the other ReadSession.
SessionReading ReadSession(const SessionFiles& files, double force_limit);

/// Reads the pictures too; apart, since a table of many sessions does without them.
void LoadPictures(SessionFiles* files);

}  // namespace hpdm
