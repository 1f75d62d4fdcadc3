#pragma once

#include <cstddef>
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
  std::string scene;  ///< Name from summary.json; empty if unknown.
  /// deepest.png, the user's screenshots/, last.png and some of frames/.
  std::vector<SessionPicture> pictures;
  std::size_t screenshots_left_out = 0;  ///< Screenshots that exceed the limit of LoadPictures.
  std::vector<std::string> missing;      ///< Names of missing files.
  /// Names from scene.toml beside the log (SceneInstruments).
  std::vector<std::vector<std::string>> instruments;
  std::vector<std::string> attachments;     ///< The same (SceneAttachments).
  std::optional<ExerciseOptions> exercise;  ///< The same (SceneExercise).
};

/// Finds the files of `path`, a session's folder or a bare .lcmlog. Throws InputError if there is
/// neither.
SessionFiles FindSessionFiles(const std::filesystem::path& path);

/// Reads the log; the report has the names of the scene and its instruments. Throws InputError as
/// the other ReadSession.
SessionReading ReadSession(const SessionFiles& files, double force_limit,
                           double depth_limit = kDefaultDepthLimit);

/// Loads screenshots of up to 6 MB and other pictures of up to 1.5 MB in all, the most important
/// first. A separate function, because a table of many sessions does not need them.
void LoadPictures(SessionFiles* files);

}  // namespace hpdm
